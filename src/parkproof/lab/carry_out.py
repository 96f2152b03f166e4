"""Has a command carried out, and tells what was really sent."""

from dataclasses import replace

from parkproof.lab.accelerated_watchdog import StoppingAcceleratedRobot
from parkproof.lab.answer import Answer
from parkproof.lab.entries import Event
from parkproof.lab.parker import Parker
from parkproof.lab.watchdog import StoppingRobot


def carry_out(
    safe: StoppingRobot | StoppingAcceleratedRobot, parker: Parker, answer: Answer
) -> Answer:
    """Send a command. The parker learns it if another one was sent, or the robot stopped before.

    Parameters
    ----------
    safe : StoppingRobot or StoppingAcceleratedRobot
        The robot.
    parker : Parker
        What answered.
    answer : Answer
        Its command.

    Returns
    -------
    Answer
        With the command as it was sent, and an event if the robot was stopped unasked.

    Raises
    ------
    RobotSilentError
        If the robot does not answer.
    """
    asked: tuple[float, float] | None
    if isinstance(safe, StoppingRobot):
        asked = answer.v, answer.omega
        safe.send(*asked)
    elif answer.accelerations is None:
        asked = None
        safe.brake()
    else:
        asked = answer.accelerations
        safe.accelerate(*asked)
    sent, halted = safe.sent, safe.take_halt()
    if sent == asked and halted is None:
        return answer
    parker.carried_out(sent, halted=halted)
    events = answer.events
    if halted is not None:
        sentence = "no command came in time: the robot was stopped"
        events = (*events, Event(t=halted, name="halt", sentence=sentence, level=1))
    done = replace(answer, asked=asked, halted=halted, events=events)
    if isinstance(safe, StoppingRobot):
        v, omega = sent or (0.0, 0.0)
        return replace(done, v=v, omega=omega)
    return replace(done, accelerations=sent)
