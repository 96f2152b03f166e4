"""Signals of a block of lanes: sines found by rotation, from one time to the next.

A wave at an integration step's middle and end is that at its start, turned on by the angle of half
a step. Every `RENEWED` steps sine and cosine are worked out anew, so that roundings do not add up.
Square waves, which jump where a sine passes through 0, are worked out each time.

Compiled code: ``b`` is the buffer of `parkproof.simulation.lanes.buffer`, ``tones`` that of
`parkproof.simulation.lanes.first.all_tones`.
"""

from parkproof.model.signals import tone_value
from parkproof.scalar import cosine, rotated, sine
from parkproof.simulation.compiler import inlined
from parkproof.simulation.steps import time_in_period

from .buffer import (
    BLOCK,
    COSINE,
    END,
    MEAN,
    MIDDLE,
    OMEGA,
    PHASE,
    SIGNALS,
    SINE,
    SQUARE,
    SQUARES,
    START,
    TONE,
    TURN_COSINE,
    TURN_SINE,
    UNUSED,
)
from .updates import put_if

RENEWED = 32
"""Integration steps after which waves are worked out anew."""


@inlined
def place_of(kinds, i, m):
    """Where the rows of a signal's tone begin."""
    # the compiler sees that it is no negative number, and that rows after it do not overlap
    return ((i * kinds.shape[1] + m) & 0xFFFF) * TONE


@inlined
def prepare_turns(tones, kinds, part):
    """Find by which rotations waves go on by a part of a second."""
    for i in range(SIGNALS):
        for m in range(kinds.shape[1]):
            if kinds[i, m] != UNUSED:
                tone = place_of(kinds, i, m)
                for j in range(tone, tone + BLOCK):
                    angle = tones[OMEGA + j] * part
                    tones[TURN_SINE + j], tones[TURN_COSINE + j] = sine(angle), cosine(angle)


@inlined
def renew(tones, kinds, t):
    """Work sines and cosines out, times their amplitudes."""
    for i in range(SIGNALS):
        for m in range(kinds.shape[1]):
            if kinds[i, m] != UNUSED:
                tone = place_of(kinds, i, m)
                for j in range(tone, tone + BLOCK):
                    angle = tones[OMEGA + j] * t + tones[PHASE + j]
                    tones[SINE + j] = tones[j] * sine(angle)
                    tones[COSINE + j] = tones[j] * cosine(angle)


@inlined
def value_of(tones, j, wave, squares, t):
    """Value of a lane's tone at a time at which its sine, times its amplitude, is known.

    Where no lane has square waves, that is known before the loop.
    """
    if not squares:
        return wave
    square = tone_value(tones[j], tones[OMEGA + j], tones[PHASE + j], 1.0, t)
    return square if tones[SQUARE + j] > 0.0 else wave


@inlined
def add(b, tones, i, m, tone, squares, t):
    """Add what a tone is at a time to the signals at a step's end."""
    row = i * BLOCK
    for j in range(BLOCK):
        mean, before = b[MEAN + row + j], b[END + row + j]
        before = mean if m == 0 else before
        b[END + row + j] = before + value_of(tones, tone + j, tones[tone + SINE + j], squares, t)


@inlined
def first_signals(b, tones, kinds, t):
    """Find the signals that vary where the first step starts, as if another had ended there."""
    for i in range(SIGNALS):
        for m in range(kinds.shape[1]):
            tone = place_of(kinds, i, m)
            if kinds[i, m] == SQUARES:
                add(b, tones, i, m, tone, True, t)
            elif kinds[i, m] != UNUSED:
                add(b, tones, i, m, tone, False, t)


@inlined
def go_on(b, tones, i, m, tone, squares, middle, end):
    """Turn a tone's waves to a step's middle and end, and add what they are there."""
    row = i * BLOCK
    for j in range(BLOCK):
        k = tone + j
        turn_s, turn_c = tones[TURN_SINE + k], tones[TURN_COSINE + k]
        s, c = rotated(tones[SINE + k], tones[COSINE + k], turn_s, turn_c)
        s_end, c_end = rotated(s, c, turn_s, turn_c)
        tones[SINE + k], tones[COSINE + k] = s_end, c_end
        mean, at_middle, at_end = b[MEAN + row + j], b[MIDDLE + row + j], b[END + row + j]
        put_if(b, START + row + j, m == 0, at_end)
        at_middle = mean if m == 0 else at_middle
        at_end = mean if m == 0 else at_end
        b[MIDDLE + row + j] = at_middle + value_of(tones, k, s, squares, middle)
        b[END + row + j] = at_end + value_of(tones, k, s_end, squares, end)


@inlined
def signals_of_step(b, tones, kinds, t, h, i, steps, k):
    """Find signals at the middle and end of an integration step; its start is the last one's end.

    The step with i = −1 comes before the first of all, and only its end matters.
    """
    part = h / steps
    start = time_in_period(t, h, max(i, 0), steps)
    if i < 0:
        prepare_turns(tones, kinds, 0.5 * part)
    if i < 0 or (k * steps + i) % RENEWED == 0:
        renew(tones, kinds, start)
    if i < 0:
        first_signals(b, tones, kinds, start)
    else:
        middle, end = start + 0.5 * part, time_in_period(t, h, i + 1, steps)
        for signal in range(SIGNALS):
            for m in range(kinds.shape[1]):
                tone = place_of(kinds, signal, m)
                if kinds[signal, m] == SQUARES:
                    go_on(b, tones, signal, m, tone, True, middle, end)
                elif kinds[signal, m] != UNUSED:
                    go_on(b, tones, signal, m, tone, False, middle, end)


@inlined
def start_and_go_on(b, tones, i, m, tone, squares, start):
    """Add what a tone is at a step's start, and turn its waves to the step's end."""
    row = i * BLOCK
    for j in range(BLOCK):
        k = tone + j
        s, c = tones[SINE + k], tones[COSINE + k]
        mean, before = b[MEAN + row + j], b[START + row + j]
        before = mean if m == 0 else before
        b[START + row + j] = before + value_of(tones, k, s, squares, start)
        tones[SINE + k], tones[COSINE + k] = rotated(
            s, c, tones[TURN_SINE + k], tones[TURN_COSINE + k]
        )


@inlined
def signals_at_start(b, tones, kinds, t, h, i, steps, k):
    """Find signals at the start of an integration step, which is all that Euler's asks for."""
    start = time_in_period(t, h, max(i, 0), steps)
    if i < 0:
        prepare_turns(tones, kinds, h / steps)
    else:
        if (k * steps + i) % RENEWED == 0:
            renew(tones, kinds, start)
        for signal in range(SIGNALS):
            for m in range(kinds.shape[1]):
                tone = place_of(kinds, signal, m)
                if kinds[signal, m] == SQUARES:
                    start_and_go_on(b, tones, signal, m, tone, True, start)
                elif kinds[signal, m] != UNUSED:
                    start_and_go_on(b, tones, signal, m, tone, False, start)
