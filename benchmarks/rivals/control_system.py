"""python-control: a discrete-time nonlinear system and its response, one call a trial.

Robot, law and records are one system without inputs. That is faster than what one would rather
write: a plant and a controller, connected by `interconnect`.
"""

from collections.abc import Callable
from typing import Any

import control
import law
import numpy as np
from work import Found, Work, found_from


def prepare(work: Work) -> Callable[[], Found]:
    """Define the systems."""
    p, h = work.parameters, work.period
    names = 5 + len(law.NOTHING_YET)
    times = np.arange(work.samples + 1) * h

    def system(j: int) -> Any:
        way, truth = float(work.ways[j]), tuple(work.truths[j].tolist())

        def update(t: Any, x: Any, _input: Any, _parameters: Any) -> Any:
            s = x.tolist()
            *state, kept = law.euler_period(float(t), h, way, *s[:5], s[5:], truth, p)
            return (*state, *kept)

        return control.nlsys(update, None, inputs=0, states=names, dt=h)

    systems = [system(j) for j in range(len(work.ways))]

    def park(j: int) -> Any:
        begin = [*work.starts[j], *law.NOTHING_YET]
        return control.input_output_response(systems[j], times, 0.0, begin).states[:, -1]

    def run() -> Found:
        last = np.array([park(j) for j in range(len(systems))])
        return found_from(last[:, 5:], work)

    return run
