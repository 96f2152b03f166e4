"""Gains of homogeneous control: the times reached, and that every bound asked for is kept."""

import itertools
from typing import Any

import numpy as np
import pytest
from flint import arb

from parkproof.errors import InputError
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.homogeneous_rate import proven_rate
from parkproof.proof.lmi import homogeneous_gains

STARTS = [(1.0, 0.0, 0.0), (0.64, 1.7, 3.01)]
SECTION4: dict[str, Any] = {"b1": (0.5, 1.5), "gamma": (1.0, 2.0), "disturbance": 2.5}


@pytest.mark.parametrize(
    ("b2", "tau_max", "seconds"),
    [((1.0, 1.0), 20.0, 8.05), ((1.0, 1.0), 60.0, 3.79), ((0.8, 1.25), 20.0, 11.3)],
)
def test_times_that_are_reached_under_the_papers_bounds(
    b2: tuple[float, float], tau_max: float, seconds: float
) -> None:
    found = homogeneous_gains(**SECTION4, b2=b2, tau_max=tau_max, starts=STARTS)
    assert found is not None
    assert found.settling_time <= seconds
    proof = Ellipsoid(found.ellipsoid, found.feedback)
    assert proof.prove_rate(
        found.rate, found.rho, SECTION4["b1"], b2, SECTION4["gamma"], SECTION4["disturbance"]
    )
    assert proof.input_bound() <= arb(tau_max)
    for start in STARTS:
        assert proof.level([(x, x) for x in start]) <= arb(found.level)
    assert all(float(f"{x:.8g}") == x for x in (*found.ellipsoid, *found.feedback, found.rate))


def test_simulated_worst_cases_settle_within_the_proven_time_and_input() -> None:
    """Integrated in small steps under gains and disturbances at their ends, V as in its definition.

    The disturbance pushes V up, or down, or is a square wave.
    """
    found = homogeneous_gains(**SECTION4, tau_max=20.0, starts=STARTS)
    assert found is not None
    a, b, c, d, e, f = found.ellipsoid
    P, k = np.array([[a, b, c], [b, d, e], [c, e, f]]), np.array(found.feedback)
    cases = list(itertools.product((0.5, 1.5), (1.0, 2.0), (-1.0, 0.0, 1.0), STARTS))
    b1, gamma, push = (np.array([case[i] for case in cases]) for i in range(3))
    x = np.array([case[3] for case in cases])
    V, h, most = np.full(len(cases), found.level), 5e-4, 0.0
    for n in range(int(found.settling_time / h)):
        for _ in range(4):  # Newton's method from the last V, which is close
            z = x / np.array([V**3, V**2, V]).T
            form = np.einsum("ni,ij,nj->n", z, P, z)
            slope = 2.0 * np.einsum("ni,ij,nj->n", z * np.array([3.0, 2.0, 1.0]), P, z)
            V = np.maximum(V * np.exp(np.clip((form - 1.0) / slope, -0.5, 0.5)), 1e-2)
        z = x / np.array([V**3, V**2, V]).T
        above = V - np.maximum(found.level - found.rate * n * h, 0.014)
        assert np.all(above < 1e-3)
        tau = z @ k
        most = max(most, float(np.abs(tau).max()))
        phi = 2.5 * np.where(push == 0.0, np.sign(np.sin(3.0 * n * h)), push * np.sign(z @ P[2]))
        x = x + h * np.array([b1 * x[:, 1], x[:, 2], gamma * tau + phi]).T
    assert np.all(V <= 0.015)
    assert 10.0 < most <= 20.0


def test_a_disturbance_that_the_input_does_not_dominate_is_refused() -> None:
    with pytest.raises(InputError, match=r"does not dominate.*tau_max above 2\.5"):
        homogeneous_gains(**SECTION4, tau_max=2.5, starts=STARTS)


def test_what_cannot_be_found_is_none() -> None:
    assert homogeneous_gains(**SECTION4, tau_max=3.0, starts=STARTS) is None


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"b1": (0.0, 1.0)}, "b1"),
        ({"b2": (1.2, 0.8)}, "b2"),
        ({"disturbance": -1.0}, "disturbance"),
        ({"tau_max": 0.0}, "tau_max"),
        ({"starts": []}, "at least one"),
        ({"starts": [(0.0, 0.0, 0.0)]}, "at least one"),
        ({"state_max": (0.9, 9.0, 9.0)}, "a start lies outside"),
    ],
)
def test_bounds_that_are_none_are_refused(change: dict[str, Any], message: str) -> None:
    arguments = {**SECTION4, "tau_max": 20.0, "starts": STARTS} | change
    with pytest.raises(InputError, match=message):
        homogeneous_gains(**arguments)


def test_bounds_of_the_states_are_kept_and_cost_time() -> None:
    limits = (1.3, 1.0, 3.0)
    given: dict[str, Any] = {"b1": (0.5, 1.5), "tau_max": 20.0, "starts": STARTS[:1]}
    free = homogeneous_gains(**given)
    held = homogeneous_gains(**given, state_max=limits)
    assert free is not None
    assert held is not None
    sizes = Ellipsoid(held.ellipsoid, held.feedback).sizes(arb(held.level))
    assert all(size <= limit for size, limit in zip(sizes, limits, strict=True))
    sizes = Ellipsoid(free.ellipsoid, free.feedback).sizes(arb(free.level))
    assert any(size > limit for size, limit in zip(sizes, limits, strict=True))
    assert held.settling_time > free.settling_time


def test_wider_gains_more_disturbance_and_less_input_cost_time() -> None:
    def seconds(**change: object) -> float:
        given: dict[str, Any] = {"b1": (0.8, 1.2), "tau_max": 20.0, "starts": STARTS[:1]} | change
        found = homogeneous_gains(**given)
        assert found is not None
        return found.settling_time

    easy = seconds()
    harder = ({"b1": (0.5, 1.5)}, {"b2": (0.8, 1.25)}, {"disturbance": 1.0}, {"tau_max": 10.0})
    assert all(seconds(**change) > easy for change in harder)


def test_the_rate_of_given_gains_is_the_one_that_they_were_found_with() -> None:
    found = homogeneous_gains(**SECTION4, tau_max=40.0, starts=STARTS)
    assert found is not None
    again = proven_rate(found.ellipsoid, found.feedback, **SECTION4)
    assert again == (found.rate, found.rho)
    wider = proven_rate(found.ellipsoid, found.feedback, **SECTION4 | {"b1": (0.4, 1.5)})
    assert wider is None or wider[0] < found.rate
    assert proven_rate((1.0, 2.0, 0.0, 1.0, 0.0, 1.0), found.feedback, b1=(1.0, 1.0)) is None


def test_more_starts_inside_the_hull_change_nothing() -> None:
    given: dict[str, Any] = {"b1": (0.5, 1.5), "tau_max": 20.0}
    alone = homogeneous_gains(**given, starts=[(1.0, 0.5, 0.0)])
    more = homogeneous_gains(**given, starts=[(1.0, 0.5, 0.0), (-1.0, -0.5, 0.0), (0.5, 0.25, 0.0)])
    assert alone is not None
    assert more is not None
    assert more.settling_time == pytest.approx(alone.settling_time, rel=1e-4)
