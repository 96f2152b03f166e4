"""Integration steps against what they must amount to: the same robot on the floor."""

import itertools
import math
from collections.abc import Callable

import pytest

from parkproof.model.chained import body_inputs, chained_inputs
from parkproof.model.homography import Homography
from parkproof.model.image_unicycle import gains_under, image_of
from parkproof.model.overhead import PinholeTable
from parkproof.model.unicycle import Pose
from parkproof.simulation.image_steps import image_chained_step, image_turning_step
from parkproof.simulation.steps import chained_step, turning_step

VIEW = PinholeTable(
    height=3.0, focal_length=380.0, tilt_deg=25.0, roll_deg=20.0, aspect=1.1, unit=120.0
).view
PAPERS = ((0.7, 1.3, 1.0),) * 3
FLAT = Homography((1.0 / 0.7, 0.0, 0.0, 0.0, 1.0 / 0.7, 0.0, 0.0, 0.0, 1.0))
FLOOR = (-0.6, 0.3, 0.4)
RATES = (0.5, 0.6, 0.7, -0.8, -0.6, -0.4)
"""v̇ and ω̇, both linear in time over a step of 1 s."""


def many(step: Callable[..., tuple[float, ...]], state: tuple[float, ...], n: int) -> list[float]:
    """The state after 1 s in n steps."""
    for i in range(n):
        ends = [(i + part) / n for part in (0.0, 0.5, 1.0)]
        rates = [RATES[j] + (RATES[j + 2] - RATES[j]) * at for j in (0, 3) for at in ends]
        state = step(*state, rates, 1.0 / n)
    return list(state)


def on_the_floor(x, y, theta, v, omega, rates, h):
    return turning_step(x, y, theta, v, omega, *[(1.0, 1.0, 1.0)] * 3, *rates, h)


def in_the_image(x, y, theta, v, omega, rates, h):
    camera = VIEW.from_goal.entries
    return image_turning_step(x, y, theta, v, omega, camera, True, *rates, h)


def test_a_robot_s_image_moves_as_the_robot_does_on_the_floor() -> None:
    image = VIEW.image_pose(FLOOR)
    end = many(on_the_floor, (*FLOOR, 0.2, 0.3), 64)
    seen = many(in_the_image, (*image, 0.2, 0.3), 64)
    x, y, psi = VIEW.image_pose((end[0], end[1], end[2]))
    assert seen[:2] == pytest.approx([x, y], abs=1e-8)
    assert math.remainder(seen[2] - psi, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-8)
    assert seen[3:] == pytest.approx(end[3:])


@pytest.mark.parametrize("own", [True, False])
def test_a_camera_that_looks_straight_down_is_the_paper_s_with_equal_scales(own: bool) -> None:
    state, scales = (0.3, -0.2, 2.0, 0.5, -0.4), ((0.7, 0.7, 1.0),) * 3
    expected = turning_step(*state, *scales, *RATES, 0.3)
    assert image_turning_step(*state, FLAT.entries, own, *RATES, 0.3) == pytest.approx(expected)
    expected = chained_step(*state, *scales, *RATES, 0.3)
    assert image_chained_step(*state, FLAT.entries, *RATES, 0.3) == pytest.approx(expected)


def test_in_the_chart_and_outside_it_a_robot_goes_the_same_way() -> None:
    """Where nothing accelerates, u0 and u1 follow from v and ω, which turn the heading."""
    camera, (x, y, theta) = VIEW.from_goal.entries, VIEW.image_pose(FLOOR)
    x2, n = math.tan(theta), 400
    state = (x, y, x2, *chained_inputs(0.4, 0.0, x2))
    charted = many(lambda *s: image_chained_step(*s[:5], camera, *[0.0] * 6, s[6]), state, n)
    posed = many(
        lambda *s: image_turning_step(*s[:5], camera, False, *[0.0] * 6, s[6]),
        (x, y, theta, 0.4, 0.0),
        n,
    )
    assert charted[:2] == pytest.approx(posed[:2], abs=1e-9)
    assert math.atan(charted[2]) == pytest.approx(posed[2])
    assert body_inputs(charted[3], charted[4], charted[2]) == pytest.approx((0.4, 0.0))


@pytest.mark.parametrize("kind", ["chained", "turning"])
def test_steps_under_a_camera_are_of_fourth_order(kind: str) -> None:
    camera, (x, y, theta) = VIEW.from_goal.entries, VIEW.image_pose(FLOOR)

    def end(n: int) -> list[float]:
        if kind == "turning":
            return many(in_the_image, (x, y, theta, 0.2, 0.3), n)
        step = lambda *s: image_chained_step(*s[:5], camera, *s[5], s[6])  # noqa: E731
        return many(step, (x, y, math.tan(theta), 0.2, 0.3), n)

    exact = end(256)
    errors = [max(abs(a - b) for a, b in zip(end(n), exact, strict=True)) for n in (4, 8, 16)]
    orders = [math.log2(one / two) for one, two in itertools.pairwise(errors)]
    assert all(3.6 < order < 4.6 for order in orders), orders


def test_gains_under_a_camera_are_those_of_the_image_of_the_pose() -> None:
    x, y, psi = VIEW.image_pose(FLOOR)
    image = image_of(VIEW.to_goal, Pose(*FLOOR))
    gains = gains_under(VIEW.from_goal.entries, x, y, math.cos(psi), math.sin(psi))
    assert gains == pytest.approx((image.a, image.beta))
