"""Drake: a LeafSystem in Python with a periodic update, one simulator a trial.

Robot, law and records are one system with one discrete state and no ports. That is faster than what
one would rather write: a plant and a controller, connected in a diagram.
"""

from collections.abc import Callable
from typing import Any

import law
import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem
from work import Found, Work, found_from


class Loop(LeafSystem):
    """The closed loop of one trial."""

    def __init__(self, work: Work, j: int) -> None:
        super().__init__()
        self._h, self._p = work.period, work.parameters
        self._way, self._truth = float(work.ways[j]), tuple(work.truths[j].tolist())
        self.DeclareDiscreteState([*work.starts[j], *law.NOTHING_YET])
        self.DeclarePeriodicDiscreteUpdateEvent(self._h, 0.0, self.update)

    def update(self, context: Any, following: Any) -> None:
        """One period."""
        s = context.get_discrete_state_vector().value().tolist()
        *state, kept = law.euler_period(
            context.get_time(), self._h, self._way, *s[:5], s[5:], self._truth, self._p
        )
        following.set_value((*state, *kept))


def prepare(work: Work) -> Callable[[], Found]:
    """Build nothing yet: a simulator's set-up is short against its run."""

    def park(j: int) -> Any:
        simulator = Simulator(Loop(work, j))
        simulator.Initialize()
        simulator.AdvanceTo(work.samples * work.period)
        return simulator.get_context().get_discrete_state_vector().value()

    def run() -> Found:
        last = np.array([park(j) for j in range(len(work.ways))])
        return found_from(last[:, 5:], work)

    return run
