"""Trials as arrays: what the lanes read of scenarios."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from parkproof.errors import InputError
from parkproof.scenario import Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble, simulate_trials
from parkproof.simulation.trials import Trials, trials_of

Make = Callable[..., Scenario]


@pytest.fixture(scope="module")
def given(section4: Make) -> list[Scenario]:
    starts = (Start(state=(-0.2, 0.3, -0.5, 5.6, 0.8)), Start(pose=(-1.0, 0.5, 2.0)))
    return [
        section4(start=start, truth=truth, duration=0.2, control_period=0.01)
        for start in starts
        for truth in ("sines", "squares", "noise", "adversary")
    ]


def test_trials_carry_what_scenarios_say(given: list[Scenario]) -> None:
    trials = trials_of(given)
    assert len(trials) == len(given)
    assert trials.in_chart.tolist() == [1.0] * 4 + [0.0] * 4
    assert trials.state[:, 0].tolist() == [-0.2, 0.3, -0.5, 5.6, 0.8]
    assert trials.state[:, 4].tolist() == [-1.0, 0.5, 2.0, 0.0, 0.0]
    assert trials.jump.tolist() == [False, True, False, False] * 2
    assert trials.adversary[:, 3].tolist() == [2.5, 2.5]
    assert trials.mean[:, 0].tolist() == [1.5, 1.5, 0.0, 0.0]
    assert trials.scale_tones.shape == (3, 0, 4, 8)


def test_trials_as_arrays_give_what_their_scenarios_give(given: list[Scenario]) -> None:
    rows, arrays = simulate_ensemble(given), simulate_trials(given[0], trials_of(given))
    assert all(np.array_equal(rows[n], arrays[n], equal_nan=n != "outcome") for n in rows)


def test_some_of_the_trials_keep_the_order_asked_for(given: list[Scenario]) -> None:
    some = trials_of(given).some(np.array([5, 1]))
    again = trials_of([given[5], given[1]])
    most = again.tones.shape[1]  # noise of another trial leaves room for more tones
    assert np.array_equal(some.tones[:, :most], again.tones)
    assert not some.tones[:, most:].any()
    assert np.array_equal(some.state, again.state)


def test_arrays_of_other_shapes_are_refused(given: list[Scenario]) -> None:
    parts: dict[str, Any] = dict(trials_of(given).__dict__)
    with pytest.raises(InputError, match=r"mean has the shape \(3, 8\): must be \(4, 8\)"):
        Trials(**(parts | {"mean": parts["mean"][:3]}))
    with pytest.raises(InputError, match=r"camera has the shape \(9, 8\): must be \(17, 8\)"):
        Trials(**(parts | {"camera": np.zeros((9, 8))}))
    with pytest.raises(InputError, match="no trials"):
        Trials(**{name: array[..., :0] for name, array in parts.items()})
