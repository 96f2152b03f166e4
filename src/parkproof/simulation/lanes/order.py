"""Which lane carries which trial: those in the same step of a law go side by side.

A law goes through a group of lanes once for each step in which some of them are. When a trial
changes its step, a few times in a run, trials change places, so that hardly any group has more than
one step in it. A trial takes all that it has with it; what comes of it does not change.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`.
"""

from parkproof.simulation.compiler import inlined

from .buffer import BLOCK, GROUP, GROUPS, ROWS, STEP, STEPS, TONE_ROWS

ROW_COUNT = len(ROWS)


@inlined
def exchange_numbers(numbers, count, one, other):
    """Exchange two lanes' numbers in so many rows of a buffer."""
    for row in range(0, count * BLOCK, BLOCK):
        kept = numbers[row + one]
        numbers[row + one] = numbers[row + other]
        numbers[row + other] = kept


@inlined
def exchange_rows(rows, one, other):
    """Exchange two lanes' numbers in an array of rows."""
    for i in range(rows.shape[0]):
        rows[i, one], rows[i, other] = rows[i, other], rows[i, one]


@inlined
def exchange(b, ring, tones, kinds, adversary, keys, cameras, one, other):
    """Have two trials change places."""
    exchange_numbers(b, ROW_COUNT, one, other)
    exchange_numbers(tones, kinds.size * TONE_ROWS, one, other)
    exchange_numbers(adversary, 2, one, other)
    exchange_rows(keys, one, other)
    exchange_rows(cameras, one, other)
    for k in range(ring.shape[0]):
        for i in range(ring.shape[1]):
            ring[k, i, one], ring[k, i, other] = ring[k, i, other], ring[k, i, one]


@inlined
def arrange(b, ring, tones, kinds, adversary, keys, cameras):
    """Sort trials by their steps."""
    first = 0
    for step in range(STEPS - 1):
        while first < BLOCK and b[STEP + first] <= step:
            first += 1
        last = BLOCK - 1
        while last > first:
            if b[STEP + last] <= step:
                exchange(b, ring, tones, kinds, adversary, keys, cameras, first, last)
                while b[STEP + first] <= step:  # ends at the latest where the exchange put ``last``
                    first += 1
            last -= 1


@inlined
def find_steps(b, groups):
    """List the groups of lanes in which a step is in force, for each of the five steps."""
    for step in range(STEPS):
        groups[step] = 0
    for first in range(0, BLOCK, GROUP):
        here = 0
        for j in range(first, first + GROUP):
            here |= 1 << int(b[STEP + j])
        for step in range(STEPS):
            if here & (1 << step):
                groups[STEPS + step * GROUPS + groups[step]] = first
                groups[step] += 1


@inlined
def count_of(groups, step):
    """Say how many groups have lanes in a step."""
    return groups[int(step)]


@inlined
def group_of(groups, step, i):
    """Give the first lane of one of the groups that have lanes in a step."""
    # so that the compiler sees that it is an index
    return groups[STEPS + int(step) * GROUPS + i] & (BLOCK - GROUP)
