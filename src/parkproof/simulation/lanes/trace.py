"""Every sample of a block's first lane, for those who ask for it.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`; ``trace`` is an array of
`TRACED` and β × samples. The lanes of such a block are copies of one trial, which are always in the
same step, and so never change places.
"""

from parkproof.simulation.compiler import inlined

from .buffer import CHART, ENDED, S0, S1, S2, S3, S4, STEP, TAU1, TAU2

TRACED = (STEP, S0, S1, S2, S3, S4, CHART, TAU1, TAU2)
"""Rows of which every sample is kept, before the gain β."""

ROWS_TRACED = len(TRACED) + 1


@inlined
def no_trace(_b, _trace, _k, _gain):
    """Keep nothing."""


@inlined
def trace_lane(b, trace, k, gain):
    """Keep the k-th sample."""
    if b[ENDED] == 0.0:
        for i in range(ROWS_TRACED - 1):
            trace[i, k] = b[TRACED[i]]
        trace[ROWS_TRACED - 1, k] = gain(b, 0)
