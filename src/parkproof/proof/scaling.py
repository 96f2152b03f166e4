"""Links of a run's proof in normalised form, scaled to other speeds without searching anew.

Time and the size of the later states can be scaled exactly (theory of homogeneous loops): if V and
a rate are proved for gains of the normalised form, scaled ones follow for the scaled gains. Scaled
numbers are rounded, so what is finally written is proved again.
"""

from dataclasses import dataclass
from typing import Any

from parkproof.laws.time_scale import scaled_approach, scaled_pair
from parkproof.proof.checker.chains import TwoChain
from parkproof.proof.checker.links import PowerIntegrator
from parkproof.proof.checker.squares import ThreeChainWithSquares
from parkproof.validate import Ratio

ROUNDING = 1.003
"""Room left for the rounding of scaled gains, in rates and sizes."""


def _short(value: float) -> float:
    return float(f"{value:.5g}")


@dataclass(frozen=True)
class TwoChainForm:
    """A chain of two under normalised gains.

    Attributes
    ----------
    q : str
        q2 as a ratio.
    k : pair of floats
        k̃1, k̃3.
    link : dict
        Weight k2, rate and sizes, proved; see `parkproof.proof.find_links.two_chain_link`.

    Examples
    --------
    >>> form = TwoChainForm("7/9", (1.5, 6.5), {"k2": 7.5, "rate": 1.3, "sizes": [2.1, 28, 20]})
    >>> k, _ = form.scaled(2.0)
    >>> k[0], round(k[1] / 6.5, 3)
    (3.0, 2.438)
    """

    q: str
    k: tuple[float, float]
    link: dict[str, Any]

    def scaled(self, speed: float) -> tuple[tuple[float, float], PowerIntegrator]:
        """Gains and link of the loop that is ``speed`` times as fast."""
        q = float(Ratio(self.q, "q2"))
        one = speed ** (1.0 / q)
        k1, k2 = scaled_pair(self.k, self.q, speed=speed)
        k = (_short(k1), _short(k2))
        weight = _short(self.link["k2"] * one**2)
        first, *others = self.link["sizes"]
        sizes = (first * ROUNDING, *(one**2 * size * ROUNDING for size in others))
        rate = speed * self.link["rate"] / ROUNDING
        return k, PowerIntegrator(TwoChain(self.q, k, weight), rate, sizes)


@dataclass(frozen=True)
class ThreeChainForm:
    """Step 2 under normalised gains, with b1 = α2 (run-up speed 1).

    Attributes
    ----------
    q : str
        q1 as a ratio.
    l : tuple of 3 floats
        Gains.
    link : dict
        Weights k and s, rate and sizes; see `parkproof.proof.find_links.approach_link`.

    Examples
    --------
    >>> link = {"k": [3.2, 130.0], "s": [0.0, 0.0], "rate": 1.2, "sizes": [2.1, 20, 1400, 460]}
    >>> l, _ = ThreeChainForm("9/11", (2.0, 4.2, 21.0), link).scaled(1.0, 0.5)
    >>> l[0]
    4.0
    """

    q: str
    l: tuple[float, float, float]  # noqa: E741  (the paper's name)
    link: dict[str, Any]

    def scaled(
        self, speed: float, cruise: float
    ) -> tuple[tuple[float, float, float], PowerIntegrator]:
        """Gains and link of the loop that is ``speed`` times as fast at another run-up speed."""
        q = float(Ratio(self.q, "q1"))
        two, three = (speed / cruise) ** (1.0 / q), (speed**2 / cruise) ** (1.0 / (2.0 * q - 1.0))
        l1, l2, l3 = scaled_approach(self.l, self.q, speed=speed, cruise=cruise)
        gains = (_short(l1), _short(l2), _short(l3))
        k1, k2 = self.link["k"]
        weights = (_short(k1 * two**2), _short(k2 * three**2))
        one, other = self.link["s"]
        squares = (_short(one / two**2), _short(other / three**2))
        chain = ThreeChainWithSquares(self.q, gains, weights, 1.0, squares)
        s1, s2, s3, s4 = (size * ROUNDING for size in self.link["sizes"])
        sizes = (s1, s2 * two**2, s3 * three**2, s4 * three**2)
        rate = speed * self.link["rate"] / ROUNDING
        return gains, PowerIntegrator(chain, rate, sizes)
