"""Drake as one would write it: a plant and a controller in Python, connected in a diagram.

The plant has a continuous state and Drake's own explicit Euler integrator; the controller updates
its discrete state once a period and gives the inputs out until the next.
"""

from collections.abc import Callable
from typing import Any

import law
import numpy as np
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from work import Found, Work, found_from


class Robot(LeafSystem):
    """The plant: inputs τ, output the state."""

    def __init__(self, truth: Any) -> None:
        super().__init__()
        self._truth = tuple(truth.tolist())
        state = self.DeclareContinuousState(5)
        self._tau = self.DeclareVectorInputPort("tau", 2)
        self.DeclareStateOutputPort("state", state)

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:  # noqa: N802  (Drake's)
        """Rates of the state."""
        _, _, x2, u0, u1 = context.get_continuous_state_vector().CopyToVector().tolist()
        tau1, tau2 = self._tau.Eval(context).tolist()
        rates = law.rates(context.get_time(), x2, u0, u1, tau1, tau2, self._truth)
        derivatives.get_mutable_vector().SetFromVector(rates)


class Controller(LeafSystem):
    """The law with what is kept: input the state, outputs τ."""

    def __init__(self, work: Work, way: float) -> None:
        super().__init__()
        self._way, self._p = way, work.parameters
        self._state = self.DeclareVectorInputPort("state", 5)
        self.DeclareDiscreteState([0.0, 0.0, *law.NOTHING_YET])
        self.DeclarePeriodicDiscreteUpdateEvent(work.period, 0.0, self.update)
        self.DeclareVectorOutputPort("tau", 2, self.give, {self.xd_ticket()})

    def update(self, context: Any, following: Any) -> None:
        """One sample."""
        state = self._state.Eval(context).tolist()
        kept = context.get_discrete_state_vector().value().tolist()[2:]
        tau1, tau2, kept = law.decide(context.get_time(), self._way, *state, kept, self._p)
        following.set_value((tau1, tau2, *kept))

    def give(self, context: Any, output: Any) -> None:
        """Inputs until the next sample."""
        output.SetFromVector(context.get_discrete_state_vector().value()[:2])


def prepare(work: Work) -> Callable[[], Found]:
    """Build nothing yet: a diagram's set-up is short against its run."""

    def park(j: int) -> Any:
        builder = DiagramBuilder()
        robot = builder.AddSystem(Robot(work.truths[j]))
        controller = builder.AddSystem(Controller(work, float(work.ways[j])))
        builder.Connect(robot.get_output_port(), controller.get_input_port())
        builder.Connect(controller.get_output_port(), robot.get_input_port())
        simulator = Simulator(builder.Build())
        ResetIntegratorFromFlags(simulator, "explicit_euler", work.period)
        context = simulator.get_mutable_context()
        context.SetContinuousState(work.starts[j])
        simulator.Initialize()
        simulator.AdvanceTo(work.samples * work.period)
        return controller.GetMyContextFromRoot(context).get_discrete_state_vector().value()

    def run() -> Found:
        last = np.array([park(j) for j in range(len(work.ways))])
        return found_from(last[:, 2:], work)

    return run
