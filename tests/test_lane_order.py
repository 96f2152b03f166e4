"""Trials change places with all that they have, so that those in the same step are neighbours."""

import numpy as np

from parkproof.laws import default_parameters
from parkproof.laws.inputs import explicit_inputs, with_direct
from parkproof.laws.table import law_named
from parkproof.simulation.lanes.buffer import (
    BLOCK,
    GROUP,
    GROUPS,
    LISTED,
    NEW1,
    NEW2,
    ROWS,
    S0,
    STEP,
    STEPS,
    TONE_ROWS,
    WAY,
)
from parkproof.simulation.lanes.explicit import find_inputs
from parkproof.simulation.lanes.order import arrange, find_steps, group_of

SIGNALS, TONES, SAMPLES = 3, 2, 4


def block_of(steps: np.ndarray) -> tuple[np.ndarray, ...]:
    """Arrays whose numbers say which trial they belong to, and the steps of the trials."""
    trial = np.arange(BLOCK, dtype=float)
    b = np.tile(trial, len(ROWS))
    b[STEP : STEP + BLOCK] = steps
    ring = np.tile(trial, (SAMPLES, 6, 1))
    tones = np.tile(trial, SIGNALS * TONES * TONE_ROWS)
    kinds = np.ones((SIGNALS, TONES), int)
    return b, ring, tones, kinds, np.tile(trial, 2), np.tile(trial, (2, 1)), np.tile(trial, (9, 1))


def test_trials_are_sorted_by_their_steps_and_take_all_numbers_with_them() -> None:
    rng = np.random.default_rng(4)
    for weights in (
        (0.1, 0.2, 0.3, 0.2, 0.2),
        (0.9, 0.0, 0.1, 0.0, 0.0),
        (0.0, 0.0, 0.0, 0.0, 1.0),
    ):
        steps = rng.choice(STEPS, BLOCK, p=weights).astype(float)
        b, ring, tones, kinds, adversary, keys, cameras = block_of(steps)
        arrange(b, ring, tones, kinds, adversary, keys, cameras)
        rows = b.reshape(-1, BLOCK)
        here = np.flatnonzero(np.arange(len(ROWS)) != STEP // BLOCK)
        places = rows[here[0]].astype(int)
        assert sorted(places) == list(range(BLOCK))
        assert (rows[here] == places).all()
        assert (rows[STEP // BLOCK] == steps[places]).all()
        assert (np.diff(rows[STEP // BLOCK]) >= 0.0).all()
        assert (ring == places).all()
        assert (tones.reshape(-1, BLOCK) == places).all()
        assert (adversary.reshape(-1, BLOCK) == places).all()
        assert (keys == places).all()
        assert (cameras == places).all()


def test_a_trial_whose_step_ends_changes_places_with_one_other() -> None:
    steps = np.repeat([1.0, 2.0, 3.0, 4.0], BLOCK // 4)
    steps[3] = 2.0
    b, *others = block_of(steps)
    arrange(b, *others)
    moved = np.flatnonzero(others[3][:BLOCK] != np.arange(BLOCK))
    assert moved.tolist() == [3, BLOCK // 4 - 1]


def test_groups_are_listed_for_each_step_that_is_in_force_in_them() -> None:
    steps = np.full(BLOCK, 4.0)
    steps[: GROUP + 1] = 0.0
    steps[GROUP + 1 : 2 * GROUP] = 2.0
    b, *_ = block_of(steps)
    groups = np.full(LISTED, -1)
    find_steps(b, groups)
    assert groups[:STEPS].tolist() == [2, 0, 1, 0, GROUPS - 2]
    listed = [[group_of(groups, step, i) for i in range(groups[step])] for step in range(STEPS)]
    assert listed == [[0, GROUP], [], [GROUP], [], list(range(2 * GROUP, BLOCK, GROUP))]


def test_a_lane_has_the_inputs_of_its_own_step_whatever_its_neighbours_are_in() -> None:
    """Steps of neighbours differ as far as they can: each group goes through all four."""
    p, law = default_parameters(), law_named("corrected")
    b = np.random.default_rng(2).normal(size=BLOCK * len(ROWS))
    b[STEP : STEP + BLOCK] = np.tile([1.0, 2.0, 3.0, 4.0], BLOCK // 4)
    b[WAY : WAY + BLOCK] = 1.0
    groups = np.zeros(LISTED, int)
    find_steps(b, groups)
    assert groups[:STEPS].tolist() == [0, *[GROUPS] * 4]
    find_inputs(b, groups, S0, None, False, p, law.channels, law.direct)
    for j in range(BLOCK):
        step = b[STEP + j]
        x0, x1, x2, u0, u1 = (float(b[S0 + i * BLOCK + j]) for i in range(5))
        one, two = law.channels(step, 1.0, x0, x1, x2, u0, p)
        tau1, tau2 = explicit_inputs(one, two, u0, u1, p)
        tau2 = with_direct(tau2, law.direct(step, 1.0, x1, x2, u1, p), p)
        assert (b[NEW1 + j], b[NEW2 + j]) == (tau1, tau2)
