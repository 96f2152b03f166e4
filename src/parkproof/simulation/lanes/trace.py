"""Every sample of the first trials of a block, for those who ask for them.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`; ``trace`` is an array of
`TRACED` × samples × trials.
"""

from parkproof.simulation.compiler import inlined

from .buffer import BLOCK, CHART, ENDED, PLACE, S0, S1, S2, S3, S4, STEP, TAU1, TAU2

TRACED = ("step", "s0", "s1", "s2", "s3", "s4", "chart", "tau1", "tau2", "beta")
"""What is kept of a sample: the step, the state in its coordinates, the inputs, and β."""


@inlined
def no_trace(_b, _trace, _k, _gain):
    """Keep nothing."""


@inlined
def trace_lanes(b, trace, k, gain):
    """Keep the k-th sample of those trials that there is room for."""
    for j in range(BLOCK):
        place = int(b[PLACE + j])
        if place < trace.shape[2] and b[ENDED + j] == 0.0:
            trace[0, k, place] = b[STEP + j]
            trace[1, k, place], trace[2, k, place] = b[S0 + j], b[S1 + j]
            trace[3, k, place], trace[4, k, place] = b[S2 + j], b[S3 + j]
            trace[5, k, place], trace[6, k, place] = b[S4 + j], b[CHART + j]
            trace[7, k, place], trace[8, k, place] = b[TAU1 + j], b[TAU2 + j]
            trace[9, k, place] = gain(b, j)
