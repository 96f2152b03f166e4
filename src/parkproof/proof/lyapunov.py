"""The paper's Lyapunov functions of Steps 2 and 3, their rates, and the settling time they bound.

Both belong to the chain ż1 = α z2, ż_i = z_{i+1}, ż_r = ũ under the law of `power_integrator_law`:
r = 3 in Step 2 (x1, x2, u1 with u0 = 1), r = 2 in Step 3 (x0, u0). Theorem 1 carries what holds
for this nominal loop over to every γ(t) ≥ γ_m and |φ| ≤ φ^M.

In the linearising coordinates y_i = ⌈z_i⌋^(1/w), where w is the weight of z_i, and with
ξ_0 = y_1, ξ_i = y_{i+1} + L_i ξ_{i−1}, L_i = l_i^(1/w), every state x has a dilation Λ_s x, s > 0,
with y(Λ_s x) = s y(x), V(Λ_s x) = s² V(x) and V̇(Λ_s x) = s^(1+q) V̇(x): the ratio V̇/V^((1+q)/2)
is settled on any surface that each dilation orbit meets.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, overload

from parkproof.errors import InputError
from parkproof.laws.gains import Gains
from parkproof.proof.integrals import power_integrals, signed_power
from parkproof.validate import finite, not_negative, positive

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class ChainLyapunov:
    """V of a chain of r integrators, built by adding a power integrator.

    V = z1²/(2α) + Σ_i (1/k_i) ∫ ⌈⌈s⌋^(1/w) − ⌈z*⌋^(1/w)⌋^(2−w) ds from z* to z_{i+1}, with
    w = i·q − (i − 1) and z* = −l_i⌈ξ_{i−1}⌋^w. Values are accurate to about 1e-12 relative.

    Parameters
    ----------
    gains : sequence of r floats
        Gains l_1 … l_r of the law, positive.
    q : float
        Exponent in ((r − 1)/r, 1).
    k : sequence of r − 1 floats
        Weights of V, positive; the law does not use them.
    constant_alpha : bool
        If true (as in the paper), V holds z1²/(2α), which needs a constant α. If false, V holds
        z1²/2 and does for an α that varies.

    Raises
    ------
    InputError
        If a gain or weight is not positive, their numbers do not match, or q is out of range.

    Examples
    --------
    >>> V = ChainLyapunov(gains=(2.0, 4.2, 21.0), q=9 / 11, k=(2.4, 1.75))
    >>> round(V.rate(1.0, -2.0, -2.0, alpha=1.5), 1)
    49.5
    """

    gains: Sequence[float]
    q: float
    k: Sequence[float]
    constant_alpha: bool = True

    def __post_init__(self) -> None:
        r = len(self.gains)
        if r < 2 or len(self.k) != r - 1:
            raise InputError(
                f"{r} gains and {len(self.k)} weights: a chain has r >= 2 gains and r - 1 weights; "
                "write for example gains = (2.0, 4.2, 21.0) and k = (2.4, 17.5)"
            )
        for name in ("gains", "k"):
            values = tuple(positive(name, value) for value in getattr(self, name))
            object.__setattr__(self, name, values)
        if not (r - 1) / r < finite("q", self.q) < 1.0:
            raise InputError(
                f"q = {self.q}: must lie in ({r - 1}/{r}, 1) for {r} gains; write for example 9/11"
            )

    @property
    def exponent(self) -> float:
        """Exponent (1+q)/2 of the inequality V̇ ≤ −c·V^((1+q)/2)."""
        return 0.5 * (1.0 + self.q)

    @property
    def _weights(self) -> tuple[float, ...]:
        """Weights of z_2 … z_r (that of z_1 is 1)."""
        return tuple(i * self.q - (i - 1) for i in range(1, len(self.gains)))

    @property
    def _factors(self) -> tuple[float, ...]:
        """L_1 … L_{r−1}."""
        return tuple(gain ** (1.0 / w) for gain, w in zip(self.gains, self._weights, strict=False))

    @overload
    def value(self, *state: float, alpha: float) -> float: ...
    @overload
    def value(self, *state: "Array", alpha: "float | Array") -> "Array": ...
    def value(self, *state: "float | Array", alpha: "float | Array") -> "float | Array":
        """V at a state, or at many given as arrays.

        Parameters
        ----------
        *state : r floats or arrays
            (x1, x2, u1) in Step 2, (x0, u0) in Step 3.
        alpha : float or array
            α2 in Step 2, α1 in Step 3, positive.

        Returns
        -------
        float or array
            V ≥ 0, zero at the origin alone.

        Raises
        ------
        InputError
            If the state has not r entries, is not finite or beyond the range of floats.

        Examples
        --------
        >>> from parkproof.laws.gains import Gains
        >>> round(step2_lyapunov(Gains(), k=(2.4, 17.5)).value(1.0, 0.0, 0.0, alpha=0.5), 3)
        17.573
        """
        return _plain(self._value_and_rate(state, alpha)[0])

    @overload
    def rate(self, *state: float, alpha: float) -> float: ...
    @overload
    def rate(self, *state: "Array", alpha: "float | Array") -> "Array": ...
    def rate(self, *state: "float | Array", alpha: "float | Array") -> "float | Array":
        """V̇ along the nominal closed loop at a state, or at many given as arrays.

        Parameters
        ----------
        *state : r floats or arrays
            (x1, x2, u1) in Step 2, (x0, u0) in Step 3.
        alpha : float or array
            α2 in Step 2, α1 in Step 3, positive.

        Returns
        -------
        float or array
            V̇ per second.

        Raises
        ------
        InputError
            If the state has not r entries, is not finite or beyond the range of floats.

        Examples
        --------
        >>> from parkproof.laws.gains import Gains
        >>> step3_lyapunov(Gains(), k=2.6).rate(1.0, 0.0, alpha=1.0) < 0.0
        True
        """
        return _plain(self._value_and_rate(state, alpha)[1])

    @overload
    def decay_ratio(self, *state: float, alpha: float) -> float: ...
    @overload
    def decay_ratio(self, *state: "Array", alpha: "float | Array") -> "Array": ...
    def decay_ratio(self, *state: "float | Array", alpha: "float | Array") -> "float | Array":
        """V̇/V^((1+q)/2): the same at every dilation of a state, at most −c where c is proved.

        Parameters
        ----------
        *state : r floats or arrays
            (x1, x2, u1) in Step 2, (x0, u0) in Step 3; not the origin.
        alpha : float or array
            α2 in Step 2, α1 in Step 3, positive.

        Returns
        -------
        float or array
            The ratio; negative where V decreases.

        Raises
        ------
        InputError
            As `value`, or if V = 0, where there is no ratio.

        Examples
        --------
        >>> V = ChainLyapunov(gains=(2.0, 4.2, 21.0), q=9 / 11, k=(4.28, 311.0))
        >>> V.decay_ratio(1.0, 0.0, 0.0, alpha=1.0) < -1.24
        True
        """
        value, rate = self._value_and_rate(state, alpha)
        if not value.all():
            raise InputError(
                "state with V = 0: the ratio is not defined at the origin; give another state"
            )
        return _plain(rate / value**self.exponent)

    def state_at(self, *cube: "float | Array") -> "tuple[Array, ...]":
        """Find the state with given ξ_0, ξ_1/L_1, ξ_2/(L_1 L_2), …: the inverse coordinates.

        Parameters
        ----------
        *cube : r floats or arrays
            The coordinates; dilation multiplies them by a common factor.

        Returns
        -------
        tuple of r arrays
            (x1, x2, u1) in Step 2, (x0, u0) in Step 3.

        Examples
        --------
        >>> V = ChainLyapunov(gains=(1.0, 2.0), q=7 / 9, k=(2.6,))
        >>> [float(entry) for entry in V.state_at(1.0, 0.0)]
        [1.0, -1.0]
        """
        import numpy as np

        xi = np.asarray(cube[0], dtype=float)
        scale, state = 1.0, [xi]
        for w, L, coordinate in zip(self._weights, self._factors, cube[1:], strict=True):
            scale *= L
            before, xi = xi, np.asarray(coordinate, dtype=float) * scale
            state.append(signed_power(xi - L * before, w))
        return tuple(state)

    def _value_and_rate(
        self, state: "Sequence[float | Array]", alpha: "float | Array"
    ) -> "tuple[Array, Array]":
        import numpy as np

        if len(state) != len(self.gains):
            raise InputError(
                f"state of {len(state)} numbers: the chain has {len(self.gains)} integrators; "
                f"give {len(self.gains)} numbers"
            )
        scale = np.asarray(alpha, dtype=float)
        z = np.broadcast_arrays(*(np.asarray(entry, dtype=float) for entry in state))
        if not (scale > 0.0).all():
            raise InputError(f"alpha = {alpha}: must be greater than 0; write for example 1.0")
        with np.errstate(all="ignore"):  # what overflows is refused below
            # ż_r = ũ needs no entry: it enters through the last term, as −l_r|ξ|^(1+q).
            speeds = (scale * z[1], *z[2:])
            xi, xi_rate = z[0], speeds[0]
            value = 0.5 * z[0] ** 2 / scale if self.constant_alpha else 0.5 * z[0] ** 2
            rate = z[0] * z[1] if self.constant_alpha else z[0] * speeds[0]
            for i, (w, L, k) in enumerate(zip(self._weights, self._factors, self.k, strict=True)):
                y = signed_power(z[i + 1], 1.0 / w)
                integral, slope = power_integrals(-L * xi, y, w)
                value = value + integral / k
                # z*, at which the integrand vanishes, moves: −d⌈z*⌋^(1/w)/dt = L·dξ_{i−1}/dt.
                rate = rate + (2.0 - w) / k * slope * L * xi_rate
                xi = y + L * xi
                if i + 1 < len(speeds):
                    rate = rate + signed_power(xi, 2.0 - w) * speeds[i + 1] / k
                    xi_rate = np.abs(y) ** (1.0 - w) * speeds[i + 1] / w + L * xi_rate
            rate = rate - self.gains[-1] / self.k[-1] * np.abs(xi) ** (1.0 + self.q)
        if not (np.isfinite(value).all() and np.isfinite(rate).all()):
            raise InputError(
                "state: not finite, or V exceeds the largest float, 1.8e308; "
                "give finite numbers below about 1e40"
            )
        return value, rate


def step2_lyapunov(
    gains: Gains, *, k: Sequence[float], constant_alpha: bool = True
) -> ChainLyapunov:
    """Make the paper's V3 of Step 2, a function of (x1, x2, u1) and α2.

    Parameters
    ----------
    gains : Gains
        The gains of the law; q1 and l are used.
    k : two floats
        Weights k1, k2.
    constant_alpha : bool
        False replaces x1²/(2α2) by x1²/2: for an α2·u0 that varies.

    Returns
    -------
    ChainLyapunov
        V3.

    Raises
    ------
    InputError
        If a weight is not positive.

    Examples
    --------
    >>> from parkproof.laws.gains import Gains
    >>> V3 = step2_lyapunov(Gains(q1="9/11"), k=(4.28, 311.0))
    >>> V3.rate(1.0, -2.0, -2.0, alpha=1.5) < 0.0
    True
    """
    return ChainLyapunov(gains=gains.l, q=gains.exponents[1], k=k, constant_alpha=constant_alpha)


def step3_lyapunov(gains: Gains, *, k: float, constant_alpha: bool = True) -> ChainLyapunov:
    """Make Step 3's analogue of V3, a function of (x0, u0) and α1.

    Parameters
    ----------
    gains : Gains
        The gains of the law; q2 and k (k̃1, k̃3) are used.
    k : float
        Weight k̃2.
    constant_alpha : bool
        False replaces x0²/(2α1) by x0²/2: for an α1 that varies.

    Returns
    -------
    ChainLyapunov
        V.

    Raises
    ------
    InputError
        If the weight is not positive.

    Examples
    --------
    >>> from parkproof.laws.gains import Gains
    >>> V = step3_lyapunov(Gains(q2="3/5", k=(1.5, 6.5)), k=2.6)
    >>> V.decay_ratio(25.0, 1.0, alpha=1.5) < -1.49
    True
    """
    return ChainLyapunov(gains=gains.k, q=gains.exponents[2], k=(k,), constant_alpha=constant_alpha)


def settling_bound(value: float, *, c: float, exponent: float) -> float:
    """Bound the settling time from V̇ ≤ −c·V^a (Lemma 1): T ≤ V^(1−a)/(c(1−a)).

    Parameters
    ----------
    value : float
        V at the start, not negative.
    c : float
        c > 0 of the inequality.
    exponent : float
        a in (0, 1): the property `ChainLyapunov.exponent`.

    Returns
    -------
    float
        The bound in s.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> settling_bound(4.0, c=2.0, exponent=0.5)
    2.0
    """
    if not 0.0 < finite("exponent", exponent) < 1.0:
        raise InputError(f"exponent = {exponent}: must lie in (0, 1); write for example 10/11")
    rest = 1.0 - exponent
    power: float = not_negative("value", value) ** rest
    return power / (positive("c", c, example=1.2) * rest)


def _plain(values: "Array") -> "float | Array":
    if values.ndim:
        return values
    number: float = values.item()
    return number
