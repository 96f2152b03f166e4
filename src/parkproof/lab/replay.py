"""Carries a recorded run out again: the same pictures and times must give the same commands."""

from dataclasses import dataclass
from pathlib import Path

import msgspec

from parkproof.errors import InputError
from parkproof.lab.devices import Missing, RobotLimits
from parkproof.lab.entries import Commanded
from parkproof.lab.goal import Goal
from parkproof.lab.parker_for import parker_for
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
    sent : int
        How many the recording holds.
    first_different : Commanded or None
        The first that was sent and is not the same now.
    whole : bool
        Whether the recording was closed properly.
    lost : bool
        Whether it ended at a picture that could not be recorded in time.

    Examples
    --------
    >>> Replayed(commands=300, sent=300).sentence
    'All 300 commands are the same.'
    """

    commands: int
    sent: int
    first_different: Commanded | None = None
    whole: bool = True
    lost: bool = False

    @property
    def same(self) -> bool:
        """Whether all commands are the same, and there are any."""
        return self.first_different is None and self.commands == self.sent > 0

    @property
    def sentence(self) -> str:
        """In words."""
        cut = "" if self.whole else " The recording breaks off before the end of the run."
        if self.first_different is not None:
            sent = self.first_different
            return (
                f"The commands differ from {sent.t:.3f} s on, where v = {sent.v:.6g} m/s and ω = "
                f"{sent.omega:.6g} rad/s were sent: the recording was made by another version, or "
                f"on another kind of machine.{cut}"
            )
        if self.sent == 0:
            return f"The recording holds no command: there is nothing to compare.{cut}"
        if self.same:
            return f"All {self.commands} commands are the same.{cut}"
        why = (
            "a picture was lost when the run was recorded, and what it led to cannot be gone "
            "through again"
            if self.lost
            else "the recording holds no more frames"
        )
        return f"The first {self.commands} of {self.sent} commands are the same; then {why}.{cut}"


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
        kind: CommandedBy = msgspec.convert(known.get("commanded_by", "velocity"), CommandedBy)
        parker = parker_for(
            kind,
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
        if camera.lost or (reading is Missing.ENDED and compared < len(sent) - 1):
            break
        answer = parker.step(reading, clock.now())
        compared += 1
        if (answer.v, answer.omega, answer.accelerations) != _answered(command, kind):
            return Replayed(compared, len(sent), command, recording.whole)
        if command.asked is not None or command.halted is not None:
            velocity = command.v, command.omega
            parker.carried_out(
                velocity if kind == "velocity" else command.accelerations, halted=command.halted
            )
    return Replayed(compared, len(sent), whole=recording.whole, lost=camera.lost)


def _answered(
    command: Commanded, kind: CommandedBy
) -> tuple[float, float, tuple[float, float] | None]:
    """What the law answered when a command was sent: v, ω, and accelerations."""
    if command.asked is None:
        return command.v, command.omega, command.accelerations
    if kind == "velocity":
        return *command.asked, None
    return command.v, command.omega, command.asked
