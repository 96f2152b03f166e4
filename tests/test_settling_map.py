"""The map of settling times: only certified starts, turned ones too, and within what is proved."""

import math

import pytest

pytest.importorskip("flint", reason="needs parkproof[proof]")

import numpy as np

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.proof.whole_run import certify
from parkproof.report.settling_map import draw_settling_map, headings_of, settling_map
from parkproof.spec import Starts

KNOWN = Bounds(alpha=(0.9, 1.1), gamma=(1.0, 1.2), disturbance=0.2)
GAINS = Gains(
    lambda1=10.215,
    k=(0.62777, 2.121),
    hold=(1.5032, 6.518),
    runup_speed=1.0324,
    direction="toward",
    return_steering=False,
    ellipsoid=(0.46055276, 0.2763446, 0.071801953, 0.21982455, 0.059686852, 0.023153942),
    feedback=(-13.199497, -11.571587, -4.0280169),
)
SWITCHING = Switching(
    tolerance=(0.10324, 0.01, 0.01), hysteresis=5.0, turn_tolerance=0.01, chart_limit=30.0
)


def map_of(starts):
    found = certify(
        law="homogeneous", bounds=KNOWN, gains=GAINS, switching=SWITCHING, starts=starts.ranges
    )
    times = settling_map(found.certificate, control_period=0.005, points=3, truths=2)
    return found.certificate, times


@pytest.mark.parametrize(("low", "high"), [(-3.1416, 3.1416), (-0.3, 2.9), (1.0, 3.0), (0.0, 0.1)])
def test_headings_spread_over_their_range_and_never_leave_it(low, high):
    found = headings_of(low, high, limit=math.radians(30.0))
    assert low <= found[0] < found[-1] == high
    assert found == sorted(found)
    assert len(found) == (3 if high < 0.5 else 4 if low < -3.0 else 5)


def test_starts_that_turn_first_take_no_longer_than_is_proved(tmp_path):
    certificate, found = map_of(Starts(x=(-0.3, 0.3), y=(0.1, 0.1), theta=(-3.1416, 3.1416)))
    assert found.headings == pytest.approx((-90.0, 0.0, 90.0, 180.0), abs=0.001)
    assert found.turns == (True, False, True, True)
    assert found.worst.shape == (4, 1, 3)
    assert np.all(found.worst <= found.proved)
    # the longest of all certified starts is on the map, and none exceeds the claim
    total = certificate["claim"]["total_time"]
    assert found.proved.max() == pytest.approx(total, rel=1e-3)
    assert found.proved.max() <= total
    assert found.proved[0].max() > found.proved[1].max()  # a turn takes time
    draw_settling_map(found, tmp_path / "map.svg")
    text = (tmp_path / "map.svg").read_text()
    assert text.count("turns first") == 3
    assert "starts at rest" in text


def test_states_and_speeds_stay_inside_the_certified_box(tmp_path):
    box = Starts(x0=(-0.1, 0.2), x1=(-0.1, 0.1), x2=(0.2, 0.5), u0=(0.1, 0.3))
    certificate, found = map_of(box)
    assert found.manner == "with u0 = 0.1, u1 = 0"
    assert [math.tan(math.radians(angle)) for angle in found.headings[::2]] == [
        pytest.approx(0.2),
        pytest.approx(0.5),
    ]
    assert (found.x[0], found.x[-1], found.y[0], found.y[-1]) == (-0.1, 0.2, -0.1, 0.1)
    assert np.all(found.worst <= found.proved)
    assert found.proved.max() <= certificate["claim"]["total_time"]
    draw_settling_map(found, tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 10_000
