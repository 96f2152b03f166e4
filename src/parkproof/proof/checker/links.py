"""The links of a whole run's proof: for each chain, what its Lyapunov function says."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from flint import arb

from parkproof.proof.checker.balls import Range, exact, largest, least, point_power
from parkproof.proof.checker.chains import Chain
from parkproof.proof.checker.ellipsoid import Ellipsoid
from parkproof.proof.checker.lemmas import (
    first_integral,
    inner_level,
    input_bound,
    level_of,
    prove_rate,
    prove_sizes,
    seconds,
    state_bounds,
)

Interval = tuple[arb, arb]


class Link(Protocol):
    """What a proof says of one chain under its law."""

    def proved(self, gains: Sequence[Range], gamma: Range, phi: float) -> bool:
        """Whether all that the link says is proved for these ranges."""

    def level(self, box: Sequence[Interval]) -> arb:
        """Upper bound of V over a box of states."""

    def seconds(self, start: arb, end: arb) -> arb:
        """Time from one level to another."""

    def states(self, level: arb) -> list[arb]:
        """Bounds of the absolute states where V is at most a level."""

    def tau(self, level: arb, gamma: Range, phi: float) -> arb:
        """Bound of the input |τ| where V is at most a level."""

    def inner_level(self, tolerance: arb) -> arb:
        """A level below which all states are within a tolerance."""


@dataclass(frozen=True)
class PowerIntegrator:
    """A chain under the paper's law, made robust by Theorem 1.

    Attributes
    ----------
    chain : ThreeChain or TwoChain
        V and V̇.
    rate : float
        c.
    sizes : tuple of floats
        See `parkproof.proof.checker.lemmas.prove_sizes`.

    Examples
    --------
    >>> from parkproof.proof.checker.chains import TwoChain
    >>> link = PowerIntegrator(TwoChain("7/9", (1.5, 6.5), 2.6), 0.5, (2.1, 20.0, 20.0))
    >>> link.proved([(0.5, 1.5)], (1.0, 2.0), 2.5)
    True
    """

    chain: Chain
    rate: float
    sizes: tuple[float, ...]

    def proved(self, gains: Sequence[Range], _gamma: Range, _phi: float) -> bool:
        """Whether rate and sizes are proved; Theorem 1 covers γ and φ."""
        return prove_sizes(self.chain, self.sizes) > 0 and (
            prove_rate(self.chain, self.rate, gains) > 0
        )

    def level(self, box: Sequence[Interval]) -> arb:
        """Upper bound of V over a box of states."""
        return level_of(self.chain, box)

    def seconds(self, start: arb, end: arb) -> arb:
        """Time from one level to another."""
        return seconds(self.chain, self.rate, start, end)

    def states(self, level: arb) -> list[arb]:
        """Bounds of the absolute states where V is at most a level."""
        return state_bounds(self.chain, self.sizes, level)

    def tau(self, level: arb, gamma: Range, phi: float) -> arb:
        """Bound of the input (|τ̃| + φ^M)/γ^m where V is at most a level."""
        nominal = input_bound(self.chain, self.sizes, level)
        return ((nominal + exact(phi)) / exact(gamma[0])).upper()

    def inner_level(self, tolerance: arb) -> arb:
        """A level below which all states are within a tolerance."""
        return inner_level(self.chain, self.sizes, tolerance)

    def travel(self, level: arb) -> arb:
        """Bound of ∫|first state| dt from a level on."""
        return first_integral(self.chain, self.sizes, self.rate, level)


@dataclass(frozen=True)
class Homogeneous:
    """Step 2 under the homogeneous law, whose input V̇ ≤ −rate contains γ and φ.

    Attributes
    ----------
    ellipsoid : Ellipsoid
        P and k.
    rate : float
        β of the matrix inequality.
    rho : pair of floats
        Its ρ at both ends of γ's interval.

    Examples
    --------
    >>> Homogeneous.__dataclass_fields__.keys()
    dict_keys(['ellipsoid', 'rate', 'rho'])
    """

    ellipsoid: Ellipsoid
    rate: float
    rho: Range

    def proved(self, gains: Sequence[Range], gamma: Range, phi: float) -> bool:
        """Whether the matrix inequality holds for these ranges."""
        b1, b2 = gains
        return self.ellipsoid.sound() and self.ellipsoid.prove_rate(
            self.rate, self.rho, b1, b2, gamma, phi
        )

    def level(self, box: Sequence[Interval]) -> arb:
        """Upper bound of V over a box of states."""
        return self.ellipsoid.level(box)

    def seconds(self, start: arb, end: arb) -> arb:
        """Time from one level to another: V falls at least at the rate."""
        return largest(arb(0), (start.upper() - end.lower()) / exact(self.rate))

    def states(self, level: arb) -> list[arb]:
        """Bounds of the absolute states where V is at most a level."""
        return list(self.ellipsoid.sizes(level))

    def tau(self, _level: arb, _gamma: Range, _phi: float) -> arb:
        """Bound of the input, the same at every level."""
        return self.ellipsoid.input_bound().upper()

    def inner_level(self, tolerance: arb) -> arb:
        """A level below which all states are within a tolerance."""
        ones = self.ellipsoid.sizes(arb(1))
        levels = [
            point_power((tolerance / one).lower(), arb(1) / degree).lower()
            for one, degree in zip(ones, (3, 2, 1), strict=True)
        ]
        return least(*levels)
