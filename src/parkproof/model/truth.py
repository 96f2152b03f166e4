"""What is true of the plant and the camera: never given to a law."""

import msgspec
from msgspec.structs import force_setattr

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.model.signals import Adversary, Constant, Signal, Tone, check_range
from parkproof.validate import finite, positive


class Truth(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """True image scales, input gains and disturbances of (6).

    Parameters
    ----------
    alpha : two floats
        α1, α2: true constants. Not used where the scenario has a camera of its own.
    gamma : two signals
        γ1(t), γ2(t).
    disturbance : two signals
        φ1(t), φ2(t).
    outside_bounds : bool
        Whether the truth may violate the bounds: then the run is an experiment outside the
        guarantee, and its summary says so.

    Raises
    ------
    InputError
        If a scale is not positive.

    Examples
    --------
    >>> Truth(alpha=(0.8, 1.2)).disturbance[0].value
    0.0
    """

    alpha: tuple[float, float] = (1.0, 1.0)
    gamma: tuple[Signal, Signal] = (Constant(1.0), Constant(1.0))
    disturbance: tuple[Signal, Signal] = (Constant(0.0), Constant(0.0))
    outside_bounds: bool = False

    def __post_init__(self) -> None:
        force_setattr(self, "alpha", tuple(positive("alpha", value) for value in self.alpha))

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
            low, high = bounds.alpha_of(i)
            if not low <= self.alpha[i] <= high:
                raise InputError(
                    f"truth.alpha[{i}] = {self.alpha[i]:g}: outside its bounds [{low:g}, {high:g}];"
                    " widen the bounds, or write outside_bounds = true under [truth] for an "
                    "experiment outside the guarantee"
                )
            check_range(f"truth.gamma[{i}]", self.gamma[i], *bounds.gamma_of(i))
            phi = bounds.disturbance_of(i)
            check_range(f"truth.disturbance[{i}]", self.disturbance[i], 0.0 - phi, phi)


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
    gamma, phi = truth.gamma[i], truth.disturbance[i]
    gamma_mean, gamma_tones = (
        (bounds.gamma_of(i)[0], ()) if isinstance(gamma, Adversary) else gamma.mean_and_tones
    )
    phi_mean, phi_tones = (0.0, ()) if isinstance(phi, Adversary) else phi.mean_and_tones
    return Channel(
        gamma_mean=finite("gamma", gamma_mean),
        gamma_tones=gamma_tones,
        phi_mean=finite("disturbance", phi_mean),
        phi_tones=phi_tones,
        phi_adversary=bounds.disturbance_of(i) if isinstance(phi, Adversary) else 0.0,
    )
