"""Carries a recorded run out again: the same pictures and times must give the same commands."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from parkproof.errors import InputError
from parkproof.lab.accelerated_parker import parker_for
from parkproof.lab.devices import Missing, RobotLimits
from parkproof.lab.entries import Commanded
from parkproof.lab.goal import Goal
from parkproof.lab.recording import Recording
from parkproof.lab.safety import SafetyLimits
from parkproof.lab.settings import CommandedBy, LabSettings


@dataclass(frozen=True)
class Replayed:
    """How the commands of a replay compare with those that were sent.

    Attributes
    ----------
    commands : int
        How many were compared.
    first_different : Commanded or None
        The first that was sent and is not the same now.
    whole : bool
        Whether the recording was closed properly.

    Examples
    --------
    >>> Replayed(commands=300, first_different=None, whole=True).sentence
    'All 300 commands are the same.'
    """

    commands: int
    first_different: Commanded | None
    whole: bool

    @property
    def same(self) -> bool:
        """Whether all commands are the same."""
        return self.first_different is None

    @property
    def sentence(self) -> str:
        """In words."""
        cut = "" if self.whole else " The recording breaks off before the end of the run."
        if self.first_different is None:
            return f"All {self.commands} commands are the same.{cut}"
        sent = self.first_different
        return (
            f"The commands differ from {sent.t:.3f} s on, where v = {sent.v:.6g} m/s and ω = "
            f"{sent.omega:.6g} rad/s were sent: the recording was made by another version, or on "
            f"another kind of machine.{cut}"
        )


def replayed(path: Path | str) -> Replayed:
    """Carry a recorded run out again.

    Parameters
    ----------
    path : Path or str
        The recording.

    Returns
    -------
    Replayed
        How the commands compare.

    Raises
    ------
    InputError
        If it is no recording of a run of the laboratory.
    """
    recording = Recording.open(path)
    try:
        known = recording.settings
        parker = parker_for(
            msgspec.convert(known.get("commanded_by", "velocity"), CommandedBy),
            msgspec.convert(known["goal"], Goal),
            msgspec.convert(known["limits"], RobotLimits),
            msgspec.convert(known["settings"], LabSettings),
            msgspec.convert(known["safety"], SafetyLimits),
        )
    except (KeyError, TypeError, msgspec.ValidationError) as error:
        raise InputError(
            f"{path}: its settings are not those of a run of the laboratory ({error}); give the "
            "run.mcap that parkproof lab wrote"
        ) from error
    camera, clock = recording.replay()
    sent = recording.commands()
    clock.now()  # the loop's first reading, before the first frame
    compared = 0
    for command in sent:
        reading = camera.read(1.0)
        if reading is Missing.ENDED and compared < len(sent) - 1:
            break
        answer = parker.step(reading, clock.now())
        compared += 1
        again = answer.v, answer.omega, answer.accelerations
        if again != (command.v, command.omega, command.accelerations):
            return Replayed(compared, command, recording.whole)
    return Replayed(compared, None, recording.whole)
