"""The floor of a simulated world: how it looks, and how it grips."""

import msgspec

from parkproof.errors import InputError
from parkproof.validate import finite, positive


class FloorSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The floor: a mottled grey.

    Parameters
    ----------
    brightness : float
        Mean grey level, 30 to 225.
    contrast : float
        Standard deviation of the grey level, 0 to 60.
    friction : float
        Coefficient of friction under the wheels.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> FloorSettings(contrast=20.0).friction
    0.9
    """

    brightness: float = 130.0
    contrast: float = 14.0
    friction: float = 0.9

    def __post_init__(self) -> None:
        for name, low, high in (("brightness", 30.0, 225.0), ("contrast", 0.0, 60.0)):
            if not low <= finite(name, getattr(self, name)) <= high:
                raise InputError(
                    f"{name} = {getattr(self, name):g}: must be in [{low:g}, {high:g}]; "
                    f"write for example {name} = {0.4 * high:g}"
                )
        positive("friction", self.friction, example=0.9)
