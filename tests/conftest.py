"""What the tests share: hypothesis settings and the scenario of the paper's section 4."""

import os
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import settings

from parkproof.bounds import Bounds
from parkproof.model.signals import Adversary, Constant, Noise, Sine, Square
from parkproof.model.truth import Truth
from parkproof.scenario import RunSettings, Scenario, Start

settings.register_profile("parkproof", deadline=None, database=None)
settings.register_profile("ci", parent=settings.get_profile("parkproof"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "parkproof")

BOUNDS = Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)

TRUTHS = {
    "undisturbed": Truth(),
    "sines": Truth(
        gamma=(
            Sine(mean=1.5, amplitude=0.5, omega=1.0),
            Sine(mean=1.5, amplitude=0.5, omega=1.0, phase=1.5708),
        ),
        disturbance=(
            Sine(amplitude=2.5, omega=1.0),
            Sine(amplitude=2.5, omega=1.0, phase=1.5708),
        ),
    ),
    "squares": Truth(
        gamma=(
            Square(mean=1.5, amplitude=0.5, omega=2.0),
            Square(mean=1.5, amplitude=0.5, omega=3.0, phase=1.0),
        ),
        disturbance=(
            Square(amplitude=2.5, omega=3.0),
            Square(amplitude=2.5, omega=2.0, phase=0.5),
        ),
    ),
    "noise": Truth(
        gamma=(
            Noise(mean=1.5, amplitude=0.5, bandwidth=10.0, seed=1),
            Noise(mean=1.5, amplitude=0.5, bandwidth=10.0, seed=2),
        ),
        disturbance=(
            Noise(amplitude=2.5, bandwidth=20.0, seed=3),
            Noise(amplitude=2.5, bandwidth=20.0, seed=4),
        ),
    ),
    "adversary": Truth(gamma=(Adversary(), Adversary()), disturbance=(Adversary(), Adversary())),
    "constant": Truth(
        gamma=(Constant(1.0), Constant(2.0)), disturbance=(Constant(2.5), Constant(-2.5))
    ),
}


@pytest.fixture(scope="session")
def bounds() -> Bounds:
    """The bounds of section 4."""
    return BOUNDS


@pytest.fixture(scope="session")
def truths() -> dict[str, Truth]:
    """Truths inside these bounds, by name of their signals."""
    return TRUTHS


@pytest.fixture(scope="session")
def section4() -> Callable[..., Scenario]:
    """Make the scenario of section 4, with changes.

    ``law``, any part of a `Scenario`, any field of `RunSettings`, and ``truth`` by name.
    """

    def make(law: str = "corrected", **changes: Any) -> Scenario:
        run = {n: changes.pop(n) for n in RunSettings.__struct_fields__ if n in changes}
        truth = changes.pop("truth", "sines")
        parts: dict[str, Any] = {
            "bounds": BOUNDS,
            "truth": TRUTHS[truth] if isinstance(truth, str) else truth,
            "start": Start(state=(-0.2, 0.3, -0.5, 5.6, 0.8)),
            "run": RunSettings(**run),
        }
        return Scenario(law=law, **(parts | changes))  # type: ignore[arg-type]  # names of laws

    return make
