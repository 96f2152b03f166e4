"""Trials on a graphics processor: in numba's simulator, and what is said where there is none."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.scenario import Start
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.gpu.launch import check_gpu
from robot_scenarios import COMBINATIONS, PERIOD, scenario, trials

ONE = ("chained", None, "corrected", "explicit", False)
CHOSEN = (COMBINATIONS[0], COMBINATIONS[3], COMBINATIONS[5])

IN_THE_SIMULATOR = """
import math
import sys
import numba
import numpy as np
import parkproof.scalar as scalar
from parkproof.simulation import polynomials
from parkproof.simulation.compiler import OPTIONS, register

# the simulator runs the plain source: with the primitives that lanes have, and nothing else changed
register()
begun, two_begun = (
    numba.njit(**OPTIONS)(form)
    for form in (polynomials._begun_polynomial, polynomials._begun_polynomials)
)
ended = numba.njit(**OPTIONS)(polynomials._ended_polynomial)
wave = numba.njit(**OPTIONS)(polynomials._sine_polynomial)
scalar.spow_begun, scalar.spow_ended, scalar.sine = begun, ended, wave
scalar.spows_begun = two_begun
scalar.spow = lambda x, p: ended(begun(x, p), x, p)
scalar.tangent = lambda x: wave(x) / wave(x + 0.5 * math.pi)

from parkproof.simulation.ensemble import simulate_ensemble
from test_gpu import CHOSEN
from robot_scenarios import PERIOD, trials

found = {}
for i, combination in enumerate(CHOSEN):
    with np.errstate(all="ignore"):
        results = simulate_ensemble(trials(*combination, duration=20 * PERIOD), device="cuda")
    found |= {f"{i}.{name}": values for name, values in results.items() if name != "outcome"}
    found[f"{i}.outcome"] = np.array([outcome.value for outcome in results["outcome"]])
np.savez(sys.argv[1], **found)
"""


def test_a_thread_gives_what_a_lane_gives_bit_for_bit(tmp_path: Path) -> None:
    """Robots of three kinds, with and without cameras, noise and latency."""
    file, here = tmp_path / "found.npz", Path(__file__).parent
    subprocess.run(
        [sys.executable, "-c", IN_THE_SIMULATOR, str(file)],
        check=True,
        env={**os.environ, "NUMBA_ENABLE_CUDASIM": "1", "PYTHONPATH": os.pathsep.join(
            [str(here), *sys.path]
        )},
    )  # fmt: skip
    with np.load(file) as found:
        for i, combination in enumerate(CHOSEN):
            lanes = simulate_ensemble(trials(*combination, duration=20 * PERIOD))
            for name, values in lanes.items():
                simulated = found[f"{i}.{name}"]
                if name == "outcome":
                    assert [outcome.value for outcome in values] == simulated.tolist()
                else:
                    assert np.array_equal(values, simulated, equal_nan=True), (combination, name)


def no_gpu() -> bool:
    try:
        check_gpu()
    except InputError:
        return True
    return False


@pytest.mark.skipif(not no_gpu(), reason="there is one")
def test_that_there_is_no_graphics_processor_is_said() -> None:
    given = scenario(*ONE, start=Start(pose=(-0.4, 0.1, 0.1)))
    with pytest.raises(InputError, match=r'device = "cuda"(:| needs).*(no NVIDIA|pip install)'):
        simulate_ensemble([given], device="cuda")


def test_a_device_that_is_none_is_refused() -> None:
    given = scenario(*ONE, start=Start(pose=(-0.4, 0.1, 0.1)))
    with pytest.raises(InputError, match='device = "tpu": there is no such device; write "cpu" or'):
        simulate_ensemble([given], device="tpu")  # type: ignore[arg-type]  # on purpose
