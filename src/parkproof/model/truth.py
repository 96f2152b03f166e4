"""What is true of the plant and the camera: never given to a law."""

import msgspec
from msgspec.structs import force_setattr

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.model.signals import Adversary, Constant, Signal, Tone, check_range
from parkproof.validate import finite, positive

Gain = float | Signal
"""A number, or a signal."""

Resolved = tuple[float, tuple[Tone, ...]]
"""A signal as mean and tones."""


class Truth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """True image scales, input gains and disturbances of (6).

    Parameters
    ----------
    alpha : two floats or signals
        α1, α2: constants in the paper. Not used where the scenario has a camera of its own.
    gamma : two signals
        γ1(t), γ2(t).
    disturbance : two signals
        φ1(t), φ2(t).
    b2 : float or signal
        b2(t) in ẋ2 = b2·u1, and in a turn in θ̇ = b2·ω: 1 for the paper's robot.
    outside_bounds : bool
        Whether the truth may violate the bounds: then the run is an experiment outside the
        guarantee, and its summary says so.

    Raises
    ------
    InputError
        If a scale or b2 is not positive.

    Examples
    --------
    >>> Truth(alpha=(0.8, 1.2)).disturbance[0].value
    0.0
    """

    alpha: tuple[Gain, Gain] = (1.0, 1.0)
    gamma: tuple[Signal, Signal] = (Constant(1.0), Constant(1.0))
    disturbance: tuple[Signal, Signal] = (Constant(0.0), Constant(0.0))
    b2: Gain = 1.0
    outside_bounds: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "alpha", tuple(_positive("alpha", value) for value in self.alpha))
        force_setattr(self, "b2", _positive("b2", self.b2))

    @property
    def signals(self) -> tuple[Gain, ...]:
        """γ1, γ2, φ1, φ2, α1, α2 and b2."""
        return (*self.gamma, *self.disturbance, *self.alpha, self.b2)

    def check(self, bounds: Bounds) -> None:
        """Check that the truth lies inside the bounds, unless it is declared to lie outside.

        Parameters
        ----------
        bounds : Bounds
            What the controller may know.

        Raises
        ------
        InputError
            If it lies outside and ``outside_bounds`` is false.

        Examples
        --------
        >>> Truth(alpha=(0.8, 1.2)).check(Bounds(alpha=(0.5, 1.5)))
        """
        if self.outside_bounds:
            return
        for i in range(2):
            _check_gain(f"truth.alpha[{i}]", self.alpha[i], *bounds.alpha_of(i))
            check_range(f"truth.gamma[{i}]", self.gamma[i], *bounds.gamma_of(i))
            phi = bounds.disturbance_of(i)
            check_range(f"truth.disturbance[{i}]", self.disturbance[i], 0.0 - phi, phi)
        _check_gain("truth.b2", self.b2, *bounds.b2)


def _positive(name: str, given: Gain) -> Gain:
    """A gain that is positive at all times."""
    if isinstance(given, float | int):
        return positive(name, given)
    if not isinstance(given, Adversary) and not given.range[0] > 0.0:
        low, high = given.range
        raise InputError(
            f"{name} ranges over [{low:g}, {high:g}]: must be greater than 0 at all times; write "
            "a larger mean or a smaller amplitude"
        )
    return given


def _check_gain(name: str, given: Gain, low: float, high: float) -> None:
    """Check that a number or a signal stays inside its bounds."""
    if not isinstance(given, float):
        check_range(name, given, low, high)
    elif not low <= given <= high:
        raise InputError(
            f"{name} = {given:g}: outside its bounds [{low:g}, {high:g}]; widen the bounds, or "
            "write outside_bounds = true under [truth] for an experiment outside the guarantee"
        )


def _resolved(given: Gain, low: float) -> Resolved:
    """A gain's mean and tones; an adversary is its lower bound."""
    if isinstance(given, float):
        return given, ()
    return (low, ()) if isinstance(given, Adversary) else given.mean_and_tones


def scales(truth: Truth, bounds: Bounds) -> tuple[Resolved, Resolved, Resolved]:
    """Resolve α1, α2 and b2; an adversary takes the lowest that the bounds allow.

    Parameters
    ----------
    truth : Truth
        The gains.
    bounds : Bounds
        Their bounds.

    Returns
    -------
    three pairs
        Mean and tones of each.

    Examples
    --------
    >>> scales(Truth(alpha=(0.8, Adversary()), b2=1.2), Bounds(alpha=(0.5, 1.5), b2=(1.0, 1.5)))
    ((0.8, ()), (0.5, ()), (1.2, ()))
    """
    one, two = (_resolved(truth.alpha[i], bounds.alpha_of(i)[0]) for i in range(2))
    return one, two, _resolved(truth.b2, bounds.b2[0])


class Channel(msgspec.Struct, frozen=True):
    """Input gain and disturbance of one channel, resolved to numbers.

    Parameters
    ----------
    gamma_mean, gamma_tones
        γ(t) as mean and tones.
    phi_mean, phi_tones
        φ(t) as mean and tones, where no adversary acts.
    phi_adversary : float
        φ^M where an adversary acts, else 0.

    Examples
    --------
    >>> channel(0, Truth(), Bounds()).gamma_mean
    1.0
    """

    gamma_mean: float
    gamma_tones: tuple[Tone, ...]
    phi_mean: float
    phi_tones: tuple[Tone, ...]
    phi_adversary: float


def channel(i: int, truth: Truth, bounds: Bounds) -> Channel:
    """Resolve one channel's signals; an adversary takes its strength from the bounds.

    Parameters
    ----------
    i : int
        Channel, 0 or 1.
    truth : Truth
        The signals.
    bounds : Bounds
        The bounds that an adversary exhausts.

    Returns
    -------
    Channel
        Numbers for the plant.

    Examples
    --------
    >>> from parkproof.model.signals import Adversary
    >>> truth = Truth(gamma=(Adversary(), Adversary()), disturbance=(Adversary(), Adversary()))
    >>> resolved = channel(0, truth, Bounds(gamma=(1.0, 2.0), disturbance=2.5))
    >>> resolved.gamma_mean, resolved.phi_adversary
    (1.0, 2.5)
    """
    phi = truth.disturbance[i]
    gamma_mean, gamma_tones = _resolved(truth.gamma[i], bounds.gamma_of(i)[0])
    phi_mean, phi_tones = (0.0, ()) if isinstance(phi, Adversary) else phi.mean_and_tones
    return Channel(
        gamma_mean=finite("gamma", gamma_mean),
        gamma_tones=gamma_tones,
        phi_mean=finite("disturbance", phi_mean),
        phi_tones=phi_tones,
        phi_adversary=bounds.disturbance_of(i) if isinstance(phi, Adversary) else 0.0,
    )
