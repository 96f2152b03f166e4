"""python-control as one would write it: plant and controller in discrete time, interconnected."""

from collections.abc import Callable
from typing import Any

import control
import law
import numpy as np
from work import Found, Work, found_from


def prepare(work: Work) -> Callable[[], Found]:
    """Define the systems."""
    p, h = work.parameters, work.period
    kept_names = len(law.NOTHING_YET)
    times = np.arange(work.samples + 1) * h
    state_names, tau_names = ["x0", "x1", "x2", "u0", "u1"], ["tau1", "tau2"]

    def system(j: int) -> Any:
        way, truth = float(work.ways[j]), tuple(work.truths[j].tolist())

        def move(t: Any, x: Any, tau: Any, _parameters: Any) -> Any:
            _, _, x2, u0, u1 = x.tolist()
            return x + h * np.array(law.rates(float(t), x2, u0, u1, *tau.tolist(), truth))

        def keep(t: Any, kept: Any, state: Any, _parameters: Any) -> Any:
            return law.decide(float(t), way, *state.tolist(), kept.tolist(), p)[2]

        def give(_t: Any, kept: Any, state: Any, _parameters: Any) -> Any:
            x = state.tolist()
            return law.inputs(law.next_step(float(kept[0]), way, *x, p), way, *x, p)

        robot = control.nlsys(
            move, None, name="robot", inputs=tau_names, outputs=state_names, states=5, dt=h
        )
        controller = control.nlsys(
            keep,
            give,
            name="controller",
            inputs=state_names,
            outputs=tau_names,
            states=kept_names,
            dt=h,
        )
        return control.interconnect([robot, controller], inputs=[], outputs=state_names)

    systems = [system(j) for j in range(len(work.ways))]

    def park(j: int) -> Any:
        begin = [*work.starts[j], *law.NOTHING_YET]
        return control.input_output_response(systems[j], times, 0.0, begin).states[:, -1]

    def run() -> Found:
        last = np.array([park(j) for j in range(len(systems))])
        return found_from(last[:, 5:], work)

    return run
