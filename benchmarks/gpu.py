"""Trials on a graphics processor against lanes; without one, what its compiler makes of the kernel.

Run it from the repository root::

    pip install '.[gpu]' nvidia-cuda-nvcc-cu12
    python benchmarks/gpu.py [--trials 131072] [--rounds 3]

Where there is a processor, it carries out random trials of Section 4 (corrected law, explicit form,
15 s at 1 ms) and prints times and how far results are from those of lanes. Where there is none, it
compiles the kernel for compute capability 9.0 (an H100's), and prints what ptxas says of registers
and memory; that takes parts of numba-cuda that it does not document (tried with 0.30.4).
"""

import argparse
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numba
import numpy as np

from lanes import trials
from parkproof.errors import InputError
from parkproof.simulation.ensemble import simulate_trials
from parkproof.simulation.gpu.launch import check_gpu
from parkproof.simulation.shared import kind_of
from parkproof.simulation.trials import Trials, trials_of

CAPABILITY = (9, 0)
DRAWN = 1024
"""Different trials; more are these again."""


class LaunchedError(Exception):
    """A launch has come as far as its arguments."""


def arguments_of_a_launch() -> tuple[Any, ...]:
    """What the kernel would be given, had there been a processor."""
    from numba import cuda

    from parkproof.simulation.gpu import kernel, launch

    taken: list[Any] = []

    class Taker:
        def __getitem__(self, _size: Any) -> Any:
            return self.take

        def take(self, *given: Any) -> None:
            taken.extend(given)
            raise LaunchedError

    usual = kernel.device_kernel, launch.check_gpu, cuda.to_device, cuda.device_array
    kernel.device_kernel, launch.check_gpu = (lambda **_: Taker()), lambda: None
    cuda.to_device, cuda.device_array = np.asarray, np.empty
    shared, one = trials(1)[0], trials_of(trials(1))
    try:
        simulate_trials(shared, one, device="cuda")
    except LaunchedError:
        pass
    finally:
        kernel.device_kernel, launch.check_gpu, cuda.to_device, cuda.device_array = usual
    return tuple(taken)


def wheels() -> Iterator[str]:
    """Where the package nvidia-cuda-nvcc-cu12 keeps ptxas."""
    nvidia = find_spec("nvidia")
    for folder in (nvidia and nvidia.submodule_search_locations) or ():
        file = Path(folder) / "cuda_nvcc/bin/ptxas"
        if file.is_file():
            yield str(file)


def compile_only() -> int:
    """Compile for a processor that is not there, and print what ptxas says."""
    from numba.cuda import compiler, dispatcher
    from numba.cuda.cudadrv.driver import _Linker

    from parkproof.simulation.gpu.kernel import device_kernel

    types = tuple(numba.typeof(argument) for argument in arguments_of_a_launch())
    # device functions ask what processor they are for, though none will be launched
    dispatcher.get_current_device = lambda: SimpleNamespace(compute_capability=CAPABILITY)
    kernel = device_kernel(**kind_of(trials(1)[0], camera=False))
    code, _ = compiler.compile(
        kernel.py_func, types, device=False, abi="numba", cc=CAPABILITY, output="ltoir"
    )
    linker = _Linker(cc=CAPABILITY, lto=True)
    linker.add_ltoir(code)
    ptxas = next(wheels(), None) or shutil.which("ptxas")  # which may be older than numba's PTX
    if ptxas is None:
        print("no ptxas; to have it: pip install nvidia-cuda-nvcc-cu12", file=sys.stderr)
        return 1
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "kernel.ptx"
        made = linker.get_linked_ptx()
        file.write_bytes(made if isinstance(made, bytes) else made.code)
        command = [ptxas, "-v", f"-arch=sm_{CAPABILITY[0]}{CAPABILITY[1]}", "-o", f"{folder}/out"]
        said = subprocess.run([*command, str(file)], check=False, capture_output=True, text=True)
    if said.returncode:
        print(said.stderr or said.stdout, file=sys.stderr)
        return 1
    print("no processor here: compiled only")
    lines = [line for line in said.stderr.splitlines() if "registers" in line or "spill" in line]
    print("\n".join(line.removeprefix("ptxas info    : ").strip() for line in lines[:2]))
    return 0


def repeated(drawn: Trials, count: int) -> Trials:
    """So many trials."""
    return drawn.some(np.arange(count) % len(drawn))


def compare(count: int, rounds: int) -> int:
    """Time the processor and lanes, and compare their results."""
    many = trials(min(DRAWN, count))
    shared, drawn = many[0], trials_of(many)
    given = repeated(drawn, count)
    steps = shared.run.samples
    lanes, own = [], []
    expected = simulate_trials(shared, drawn)
    found = simulate_trials(shared, given, device="cuda")  # compiles
    for _ in range(rounds):
        begin = time.perf_counter()
        simulate_trials(shared, drawn)
        lanes.append((time.perf_counter() - begin) / len(drawn))
        begin = time.perf_counter()
        simulate_trials(shared, given, device="cuda")
        own.append((time.perf_counter() - begin) / count)
    lane, thread = statistics.median(lanes), statistics.median(own)
    print(f"{count} trials of {shared.run.duration:g} s at 1 ms, medians of {rounds} rounds")
    print(f"lanes, one core: {1e9 * lane / steps:.2f} ns a step of a trial")
    print(f"graphics processor, transfers included: {1e9 * thread / steps:.4f} ns")
    print(f"one core / graphics processor: {lane / thread:.1f}")
    same = np.mean(found["outcome"][: len(drawn)] == expected["outcome"])
    apart = np.abs(found["total"][: len(drawn)] - expected["total"])
    neither = np.isnan(found["total"][: len(drawn)]) & np.isnan(expected["total"])
    within = np.mean(neither | (apart <= 1.001 * shared.run.control_period))
    print(f"outcome as in lanes: {100 * same:.2f} %; settled within a period: {100 * within:.2f} %")
    return 0


def main() -> int:
    """Compare where there is a processor, else compile."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--trials", type=int, default=131_072)
    parser.add_argument("--rounds", type=int, default=3)
    asked = parser.parse_args()
    if min(asked.trials, asked.rounds) < 1:
        parser.error("--trials and --rounds must be at least 1")
    try:
        check_gpu()
    except InputError as error:
        if find_spec("numba_cuda") is None:
            print(error, file=sys.stderr)
            return 2
        return compile_only()
    return compare(asked.trials, asked.rounds)


if __name__ == "__main__":
    sys.exit(main())
