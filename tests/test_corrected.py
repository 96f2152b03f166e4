"""What may be chosen of the corrected law: its direction of travel, and steering on the return."""

import tomllib

import pytest

from parkproof.bounds import Bounds
from parkproof.errors import InputError
from parkproof.laws.corrected import better_direction, corrected_channels
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.parameters import LawParameters, law_parameters
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.scenario_file import scenario_from_dict
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.run import simulate


def parameters(**gains: object) -> LawParameters:
    return law_parameters(
        bounds=Bounds(),
        gains=Gains(**gains),  # type: ignore[arg-type]  # gains by name
        switching=Switching(),
        control_period=0.01,
    )


@pytest.mark.parametrize(
    ("x0", "way"), [(2.0, -1.0), (1e-9, -1.0), (0.0, 1.0), (-1e-9, 1.0), (-3.0, 1.0)]
)
@pytest.mark.parametrize(("x1", "u0"), [(0.5, 0.0), (-0.5, 4.0), (0.1, -4.0)])
def test_toward_drives_toward_the_goal_from_wherever_else(
    x0: float, way: float, x1: float, u0: float
) -> None:
    assert better_direction(x0, x1, 0.3, u0, parameters(direction="toward")) == way


def test_a_given_direction_is_kept_on_either_side_of_the_goal() -> None:
    for direction, way in (("forward", 1.0), ("backward", -1.0)):
        p = parameters(direction=direction)
        assert {better_direction(x0, 0.3, 0.0, 0.0, p) for x0 in (-2.0, 0.0, 2.0)} == {way}


@pytest.mark.parametrize("direction", ["toward", "backward"])
def test_the_published_law_has_no_other_direction(direction: str) -> None:
    data = {"law": "published", "start": {"pose": [-1, 0, 0]}, "gains": {"direction": direction}}
    with pytest.raises(InputError, match="the published law drives at u0 = 1"):
        scenario_from_dict(data, where="file")


def test_without_steering_step_3_holds_the_heading_at_every_speed() -> None:
    steers, holds = parameters(), parameters(return_steering=False)
    for u0 in (-1.5, -0.5, -0.1, 0.0, 0.05, 0.3, 1.0, 9.0):
        positions = (-2.0, 0.004, 0.1, u0)
        _, straight = corrected_channels(4.0, 1.0, *positions, holds)
        assert corrected_channels(3.0, 1.0, *positions, holds)[1] == straight
        inside = 0.1 <= abs(u0) <= 1.0
        assert (corrected_channels(3.0, 1.0, *positions, steers)[1] != straight) == inside
        approach = corrected_channels(2.0, 1.0, *positions, holds)[1]
        assert approach == corrected_channels(2.0, 1.0, *positions, steers)[1] != straight


def test_a_run_toward_the_goal_without_steering_on_the_return_parks() -> None:
    for side in (1.0, -1.0):
        scenario = Scenario(
            law="corrected",
            gains=Gains(direction="toward", return_steering=False),
            start=Start(pose=(side * 1.5, 0.4, 0.2)),
            run=RunSettings(duration=15.0, control_period=0.01, discretisation="implicit"),
        )
        run = simulate(scenario)
        assert run.outcome is Outcome.PARKED
        early = run.trajectory["t"] < 0.5
        assert (side * run.trajectory["u0"][early] <= 0.0).all()


def test_speeds_of_a_steering_that_is_switched_off_are_refused() -> None:
    with pytest.raises(InputError, match=r"return_steering = false.*leave one of them out"):
        Gains(return_steering=False, steering_speeds=(0.1, 1.0))


def test_a_scenario_file_can_choose_both() -> None:
    text = 'law = "corrected"\nstart.pose = [1, 0, 0]\n[gains]\ndirection = "toward"\n'
    gains = scenario_from_dict(
        tomllib.loads(text + "return_steering = false\n"), where="file"
    ).gains
    assert (gains.direction, gains.return_steering) == ("toward", False)
