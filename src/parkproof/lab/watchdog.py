"""A robot that is stopped whatever becomes of the program, and never sent more than it can do."""

import atexit
import math
import os
import signal
import threading
import time
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Self

from parkproof.lab.devices import AcceleratedRobot, Clock, Robot, RobotLimits
from parkproof.lab.limits import limited
from parkproof.validate import positive

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
"""Ctrl-C, a request to end, a terminal that was closed, Ctrl-\\. Windows lacks the last two."""

SUSPENSION = "SIGTSTP"
"""Ctrl-Z."""


class Stopping:
    """What keeps a robot from driving on unwatched; see `StoppingRobot`.

    Parameters
    ----------
    robot : Robot or AcceleratedRobot
        What is driven.
    clock : Clock
        Of the loop.
    timeout : float or None
        Time without a command in s after which the robot is stopped; None for no such watch.

    Raises
    ------
    InputError
        If the time is not positive.
    """

    def __init__(
        self, robot: Robot | AcceleratedRobot, *, clock: Clock, timeout: float | None = 0.3
    ) -> None:
        self._robot = robot
        self._clock = clock
        self._timeout = None if timeout is None else positive("timeout", timeout, example=0.3)
        self.stopped_by = ""
        self.late_stops = 0
        self._halts = 0
        self._halted: float | None = None
        self._fed = time.monotonic()
        self._lock = threading.RLock()  # a signal may arrive inside `send`, in the same thread
        self._closed = threading.Event()
        self._thread: threading.Thread | None = None
        self._before: dict[signal.Signals, Any] = {}
        atexit.register(self._robot.stop)

    @property
    def limits(self) -> RobotLimits:
        """What the robot can do."""
        return self._robot.limits

    def _rests(self) -> bool:
        """Whether the robot was told to stand still."""
        raise NotImplementedError

    def _carry_out(self, command: Callable[[], None]) -> None:
        """Send a command, unless the robot is stopped for good; stop it if that fails."""
        with self._lock:
            if self.stopped_by or self._closed.is_set():
                self._robot.stop()
                return
            self._watch()
            self._fed, halts = time.monotonic(), self._halts
            try:
                command()
            except BaseException:
                self.stop()
                raise
            self._fed = time.monotonic()
            # stopped meanwhile, for a signal or because it hung: what was sent came after that
            if self.stopped_by or self._halts != halts:
                self.stop()

    def stop(self) -> None:
        """Stand still at once."""
        self._robot.stop()

    def _halt(self) -> None:
        """Stop, though the loop did not ask for it."""
        self._halts += 1
        if self._halted is None:
            self._halted = self._clock.now()
        self.stop()

    def take_halt(self) -> float | None:
        """When it was stopped first since this was asked last, with the loop not asking for it.

        Returns
        -------
        float or None
            Time in s on the loop's clock; None if it was not.
        """
        halted, self._halted = self._halted, None
        return halted

    def close(self) -> None:
        """Stop, give the robot and the signals back. May be called twice."""
        if self._closed.is_set():
            self.stop()
            return
        self.release()
        self._robot.close()

    def release(self) -> None:
        """Stop and give the signals back, but not the robot: it may be wrapped again."""
        self.stop()
        self._closed.set()
        for number, handler in self._before.items():
            if signal.getsignal(number) in {self._on_signal, self._on_suspension}:
                signal.signal(number, handler)
        self._before.clear()
        atexit.unregister(self._robot.stop)
        if self._thread is not None:
            self._thread.join(timeout=1.0)

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for name in SIGNALS:
                self._take(name, self._on_signal)
            self._take(SUSPENSION, self._on_suspension)
        return self

    def _take(self, name: str, handler: Callable[[int, FrameType | None], None]) -> None:
        """Handle a signal, if there is such a one and it is not ignored."""
        number = getattr(signal, name, None)
        before = None if number is None else signal.getsignal(number)
        if number is not None and before not in {signal.SIG_IGN, None}:
            self._before[number] = before
            signal.signal(number, handler)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self.stopped_by = signal.Signals(number).name
        self.stop()  # without the lock, which another thread may hold
        before = self._before.get(signal.Signals(number))
        if callable(before):
            before(number, frame)
        else:
            raise SystemExit(128 + number)

    def _on_suspension(self, number: int, frame: FrameType | None) -> None:
        self._halt()
        before = self._before.get(signal.Signals(number))
        if callable(before):
            before(number, frame)
        else:
            os.kill(os.getpid(), signal.SIGSTOP)  # goes on here when it is told to

    def _watch(self) -> None:
        """Have a thread that watches, also when an error of the robot has ended an earlier one."""
        if self._timeout is not None and (self._thread is None or not self._thread.is_alive()):
            self._thread = threading.Thread(
                target=self._watching, args=(self._timeout,), name="watchdog", daemon=True
            )
            self._thread.start()

    def _watching(self, timeout: float) -> None:
        pause = timeout
        while not self._closed.wait(pause):
            left = self._fed + timeout - time.monotonic()
            if self._rests():
                pause = 0.5 * timeout
            elif left > 0.0:
                pause = left
            else:
                self._stop_late(timeout)
                pause = 0.5 * timeout

    def _stop_late(self, timeout: float) -> None:
        """Stop, unless a command has come in between; do not wait for one that hangs."""
        held = self._lock.acquire(timeout=0.1 * timeout)
        try:
            if not held or self._fed + timeout <= time.monotonic():
                self.late_stops += 1
                self._halt()
        finally:
            if held:
                self._lock.release()


class StoppingRobot(Stopping):
    r"""Wraps a robot: limits kept, and stopped when the program no longer drives it.

    Every command goes through `parkproof.lab.limits.limited` first. The robot is stopped

    - when nothing was sent for ``timeout`` s, by a thread, in real time;
    - at the end of the ``with`` block, however it is left;
    - on Ctrl-C, Ctrl-\, a request to end and a closed terminal, within a ``with`` block of the
      main thread: at once, before anything else, and from then on it is only told to stand still.
      The handler that was there before is called next; where there was none, `SystemExit` is
      raised, so that everything is cleaned up. A signal that is ignored, as after nohup, stays
      ignored;
    - on Ctrl-Z, likewise: before the program is suspended;
    - when a command fails, and when the interpreter ends.

    Against a program that is killed outright, or a cable that is pulled, only the robot itself can
    do something: see the dead-man rule in `docs/lab-devices.md`.

    Parameters
    ----------
    robot : Robot
        What is driven. It must bear `stop` from another thread, and in the middle of `send`.
    clock : Clock
        By which changes of speed are limited.
    timeout : float or None
        Time without a command in s after which the robot is stopped. None for no such watch: for
        worlds that are simulated at another pace.
    longest_step : float
        A command changes speed by no more than what the limits allow in this time, in s, however
        long ago the last one was.

    Raises
    ------
    InputError
        If a time is not positive.

    Attributes
    ----------
    stopped_by : str
        The signal that stopped it for good, as in "SIGINT"; empty while none has.
    late_stops : int
        How often it was stopped because no command came.

    Examples
    --------
    >>> from parkproof.lab.devices import WallClock
    >>> from parkproof.lab.robot_simulator import UdpRobotSimulator
    >>> from parkproof.lab.robots import open_robot
    >>> with UdpRobotSimulator() as simulator:
    ...     robot = open_robot(simulator.address)
    ...     with StoppingRobot(robot, clock=WallClock(), timeout=0.3) as safe:
    ...         safe.send(1e6, 0.0)
    ...         abs(safe.sent[0]) <= 0.1  # what 1 m/s² allows in 0.1 s
    True
    """

    def __init__(
        self,
        robot: Robot,
        *,
        clock: Clock,
        timeout: float | None = 0.3,
        longest_step: float = 0.1,
    ) -> None:
        super().__init__(robot, clock=clock, timeout=timeout)
        self._driven = robot
        self._longest_step = positive("longest_step", longest_step, example=0.1)
        self._sent = (0.0, 0.0)
        self._time = -math.inf

    @property
    def sent(self) -> tuple[float, float]:
        """(v, ω) as last sent, within all limits; zeros where it was stopped meanwhile."""
        return self._sent

    def _rests(self) -> bool:
        return self._sent == (0.0, 0.0)

    def send(self, v: float, omega: float) -> None:
        """Send the nearest command within the limits; to stand still if a number is not finite.

        Raises
        ------
        RobotSilentError
            As the robot does; it has been told to stop.
        """

        def command() -> None:
            now = self._clock.now()
            dt = min(now - self._time, self._longest_step)
            self._sent, self._time = limited(v, omega, *self._sent, dt, self.limits), now
            self._driven.send(*self._sent)

        self._carry_out(command)

    def stop(self) -> None:
        """Stand still at once: not slowed down within the limits, for which send zeros."""
        self._sent = (0.0, 0.0)
        self._robot.stop()
