"""Noise of a measurement as a pure function of the run's seed and the number of the sample.

Nothing is carried from sample to sample, so a run can be replayed alone, and lanes draw the same
noise as the plain run whatever their company. A 32-bit mixing function makes words of the counter;
twelve ten-bit parts of four words add up to a number that is Gaussian to 3·10⁻³ in distribution and
never beyond 6. Whole numbers stay below 2⁶³, or wrap in the bits that are masked away.
"""

import random

from parkproof.scalar import scalar

CHANNELS = 5
"""Numbers a sample: x0, x1, x2, u0, u1, or x, y, θ, v, ω."""


def keys_of(seed: int) -> tuple[int, int]:
    """Two 32-bit keys of a seed.

    Parameters
    ----------
    seed : int
        Seed of a run.

    Returns
    -------
    two ints
        Unrelated for neighbouring seeds.

    Examples
    --------
    >>> keys_of(0) == keys_of(0), keys_of(0) == keys_of(1)
    (True, False)
    """
    draw = random.Random(f"measurement {seed}")
    return draw.getrandbits(32), draw.getrandbits(32)


@scalar
def mixed(word: int) -> int:
    """Mix the bits of a 32-bit word: each bit of the answer depends on all of it.

    Parameters
    ----------
    word : int
        From 0 to 2³² − 1.

    Returns
    -------
    int
        The same range; no two words share an answer.

    Examples
    --------
    >>> mixed(1), mixed(2)
    (1753845952, 3507691905)
    """
    once = ((word ^ (word >> 16)) * 0x7FEB352D) & 0xFFFFFFFF
    twice = ((once ^ (once >> 15)) * 0x846CA68B) & 0xFFFFFFFF
    return twice ^ (twice >> 16)


@scalar
def parts_of(word: int) -> int:
    """Sum of the three ten-bit parts of a word.

    Parameters
    ----------
    word : int
        A 32-bit word.

    Returns
    -------
    int
        From 0 to 3069.

    Examples
    --------
    >>> parts_of(1 + (2 << 10) + (3 << 20))
    6
    """
    return (word & 1023) + ((word >> 10) & 1023) + ((word >> 20) & 1023)


@scalar
def standard_noise(key1: int, key2: int, sample: int, channel: int) -> float:
    """A number of mean 0 and standard deviation 1.

    Parameters
    ----------
    key1, key2 : int
        From `keys_of`.
    sample : int
        Number of the sample.
    channel : int
        0 to 4.

    Returns
    -------
    float
        Between −6 and 6.

    Examples
    --------
    >>> one, two = keys_of(7)
    >>> abs(standard_noise(one, two, 0, 0)) < 6.0
    True
    """
    word = key1 ^ mixed((key2 + 5 * sample + channel) & 0xFFFFFFFF)
    first = parts_of(mixed(word)) + parts_of(mixed((word + 1) & 0xFFFFFFFF))
    second = parts_of(mixed((word + 2) & 0xFFFFFFFF)) + parts_of(mixed((word + 3) & 0xFFFFFFFF))
    return (first + second - 6138) / 1024.0
