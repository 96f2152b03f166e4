"""Theorem 1 as a general tool: chains of length 1 to 4 under unknown gains and disturbances."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.laws.chains import power_integrator_law
from parkproof.laws.robustify import robustify

Law = Callable[[Sequence[float]], float]
GAMMA_MIN, GAMMA_MAX = 1.0, 2.0


class Chain(NamedTuple):
    """A nominal law that stabilises a chain, a disturbance it does not reject, and a band.

    The robustified loop ends inside ``band`` of |z_1|, the nominal one outside it.
    """

    gains: tuple[float, ...]
    q: float
    phi: float
    band: float

    @property
    def nominal(self) -> Law:
        return power_integrator_law(self.gains, q=self.q)

    @property
    def robust(self) -> Law:
        return robustify(self.nominal, disturbance=self.phi, gamma_min=GAMMA_MIN)


CHAINS = {
    1: Chain((1.0,), 1 / 3, 1.0, 1e-2),
    2: Chain((1.5, 6.5), 7 / 9, 5.0, 1e-3),
    3: Chain((2.0, 4.2, 21.0), 9 / 11, 20.0, 1e-3),
    4: Chain((1.0, 2.5, 8.0, 60.0), 0.9, 80.0, 1e-3),
}
START = (1.0, -0.5, 0.5, -0.3)
FACTORS = (1.3, 0.7, 1.2)


def sign(x: float) -> float:
    return float(x > 0.0) - float(x < 0.0)


def nominal_truth(t: float, wanted: float, phi: float) -> tuple[float, float]:  # noqa: ARG001
    return 1.0, 0.0


def adversary(t: float, wanted: float, phi: float) -> tuple[float, float]:  # noqa: ARG001
    return GAMMA_MIN, -phi * sign(wanted)


def sines(t: float, wanted: float, phi: float) -> tuple[float, float]:  # noqa: ARG001
    return 1.5 + 0.5 * math.sin(3.0 * t), phi * math.sin(t + 0.5)


def largest_late(
    law: Law,
    chain: Chain,
    truth: Callable[[float, float, float], tuple[float, float]],
    *,
    settled_by: float = 8.0,
    duration: float = 16.0,
    h: float = 1e-3,
) -> float:
    """Largest |z_1| after a time, of the chain ż_i = β_i z_{i+1}, ż_r = γu + φ."""
    nominal, r = chain.nominal, len(chain.gains)
    z, largest = list(START[:r]), 0.0
    for k in range(round(duration / h)):
        t = k * h
        gamma, phi = truth(t, nominal(z), chain.phi)
        rates = [FACTORS[i] * z[i + 1] for i in range(r - 1)] + [gamma * law(z) + phi]
        z = [value + h * rate for value, rate in zip(z, rates, strict=True)]
        if t >= settled_by:
            largest = max(largest, abs(z[0]))
        if largest > 1e3:
            break
    return largest


@pytest.mark.parametrize("r", [1, 2, 3, 4])
def test_nominal_law_settles_its_undisturbed_chain(r: int) -> None:
    chain = CHAINS[r]
    assert largest_late(chain.nominal, chain, nominal_truth) < 0.1 * chain.band


@pytest.mark.parametrize("r", [1, 2, 3, 4])
@pytest.mark.parametrize("truth", [adversary, sines])
def test_robust_law_settles_where_the_nominal_one_does_not(
    r: int, truth: Callable[[float, float, float], tuple[float, float]]
) -> None:
    chain = CHAINS[r]
    assert largest_late(chain.robust, chain, truth) < chain.band
    assert largest_late(chain.nominal, chain, truth) > 10.0 * chain.band


STATES = st.lists(st.floats(-10.0, 10.0), min_size=4, max_size=4)
BOUND = st.floats(0.0, 10.0)


@given(st.sampled_from([1, 2, 3, 4]), STATES, BOUND, st.floats(0.1, 5.0))
def test_adversary_leaves_exactly_the_nominal_loop(
    r: int, state: list[float], phi: float, gamma_min: float
) -> None:
    """Theorem 1's inequality is an equality for γ = γ_m and φ = −φ̄ sign ũ."""
    nominal = CHAINS[r].nominal
    wanted = nominal(state[:r])
    u = robustify(nominal, disturbance=phi, gamma_min=gamma_min)(state[:r])
    assert gamma_min * u - phi * sign(wanted) == pytest.approx(wanted, rel=1e-9, abs=1e-12)


@given(st.sampled_from([1, 2, 3, 4]), STATES, BOUND, st.floats(-1.0, 1.0), st.floats(1.0, 4.0))
def test_any_other_truth_helps_the_law(
    r: int, state: list[float], phi: float, part: float, ratio: float
) -> None:
    """(γu + φ)·sign ũ ≥ |ũ| for every γ ≥ γ_m and |φ| ≤ φ̄: then V̇ is no larger."""
    nominal = CHAINS[r].nominal
    wanted = nominal(state[:r])
    u = robustify(nominal, disturbance=phi, gamma_min=0.5)(state[:r])
    rate = 0.5 * ratio * u + part * phi
    if wanted != 0.0:
        assert rate * sign(wanted) >= abs(wanted) * (1.0 - 1e-12) - 1e-12


def test_robust_law_is_zero_where_the_nominal_one_is() -> None:
    assert CHAINS[3].robust([0.0, 0.0, 0.0]) == 0.0


@pytest.mark.parametrize(
    ("gains", "q", "message"),
    [
        ([], 0.5, "at least one integrator"),
        ([1.0, -2.0], 0.8, "gains"),
        ([1.0, 2.0, 3.0], 2 / 3, "must lie in"),
        ([1.0, 2.0], 1.0, "must lie in"),
        ([1.0], math.nan, "q"),
    ],
)
def test_a_law_that_cannot_stabilise_its_chain_is_refused(
    gains: list[float], q: float, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        power_integrator_law(gains, q=q)


def test_a_state_of_the_wrong_length_is_refused() -> None:
    with pytest.raises(InputError, match="the chain has 3"):
        CHAINS[3].nominal([1.0, 2.0])


@pytest.mark.parametrize(
    ("disturbance", "gamma_min"), [(-1.0, 1.0), (1.0, 0.0), (math.inf, 1.0), (1.0, math.nan)]
)
def test_bounds_that_theorem_1_cannot_use_are_refused(disturbance: float, gamma_min: float) -> None:
    with pytest.raises(InputError):
        robustify(CHAINS[1].nominal, disturbance=disturbance, gamma_min=gamma_min)
