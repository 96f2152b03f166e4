"""diffrax: Euler steps of one trial in a loop, vmapped over the trials and jitted.

The step in force, its ends and the metrics are no part of a differential equation, so diffrax's
solver is stepped (as its documentation shows) inside a loop that carries them.
"""

from collections.abc import Callable
from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import law_arrays
import numpy as np
from jax import lax
from law import NOTHING_YET
from work import Found, Work, found_from


def prepare(work: Work) -> Callable[[], Found]:
    """Compile."""
    jax.config.update("jax_platforms", "cpu")
    jax.config.update("jax_enable_x64", True)
    p, h = work.parameters, work.period
    solver = diffrax.Euler()

    def rates(t: Any, state: Any, args: Any) -> Any:
        return law_arrays.rates(jnp, t, state, *args)

    term = diffrax.ODETerm(rates)

    def park(start: Any, way: Any, truth: Any) -> Any:
        def sample(k: Any, carried: Any) -> Any:
            state, before, ends, kept = carried
            t = k * h
            step = law_arrays.next_step(jnp, before, way, state, p)
            onward, back = step > before, step < before
            ends = tuple(
                jnp.where(onward & (before == i + 1), t, jnp.where(back, -1.0, end))
                for i, end in enumerate(ends)
            )
            tau = law_arrays.inputs(jnp, step, way, state, p)
            kept = law_arrays.metrics(jnp, t, kept, state, tau)
            state, *_ = solver.step(term, t, t + h, state, (tau, truth), None, made_jump=False)
            return state, step, ends, kept

        zero = jnp.zeros(())
        nothing = tuple(zero + x for x in NOTHING_YET)
        begin = (tuple(start), nothing[0], nothing[1:4], nothing[4:])
        _, step, ends, kept = lax.fori_loop(0, work.samples, sample, begin)
        return jnp.stack((step, *ends, *kept))

    compiled = jax.jit(jax.vmap(park))
    given = [jnp.asarray(x) for x in (work.starts, work.ways, work.truths)]

    def run() -> Found:
        return found_from(np.array(compiled(*given)), work)

    return run
