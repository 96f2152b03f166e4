"""The differential drive: both maps, both ways, and its energy."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from parkproof.errors import InputError
from parkproof.model.drive import DifferentialDrive

sizes = st.floats(0.01, 10.0)
rates = st.floats(-100.0, 100.0)
drives = st.builds(
    DifferentialDrive, wheel_radius=sizes, half_track=sizes, mass=sizes, inertia=sizes
)


def near(values, scale=1.0):
    return pytest.approx(values, rel=1e-9, abs=1e-9 * scale)


@given(drives, rates, rates)
def test_velocity_round_trip(drive, v, omega):
    assert drive.body_velocity(*drive.wheel_speeds(v, omega)) == near((v, omega), 1e4)


@given(drives, rates, rates)
def test_torque_round_trip(drive, right, left):
    assert drive.wheel_torques(*drive.body_acceleration(right, left)) == near((right, left), 1e2)


@given(drives, rates, rates, rates, rates)
def test_wheel_power_is_the_rate_of_kinetic_energy(drive, v, omega, right, left):
    wheels = drive.wheel_speeds(v, omega)
    v_dot, omega_dot = drive.body_acceleration(right, left)
    power = right * wheels.right + left * wheels.left
    energy_rate = drive.mass * v * v_dot + drive.inertia * omega * omega_dot
    assert energy_rate == near(power, 1e6)


def test_equal_wheels_drive_straight_and_opposite_wheels_turn():
    drive = DifferentialDrive(wheel_radius=0.03, half_track=0.1, mass=1.0, inertia=0.01)
    assert drive.body_velocity(10.0, 10.0) == near((0.3, 0.0))
    assert drive.body_velocity(10.0, -10.0) == near((0.0, 3.0))


def test_parameters_become_floats():
    drive = DifferentialDrive(wheel_radius=1, half_track=1, mass=2, inertia=1)
    assert isinstance(drive.mass, float)


@pytest.mark.parametrize("name", ["wheel_radius", "half_track", "mass", "inertia"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_impossible_parameters_are_refused_by_name(name, value):
    given_values = {"wheel_radius": 0.03, "half_track": 0.1, "mass": 1.0, "inertia": 0.01}
    with pytest.raises(InputError, match=f"^{name} = "):
        DifferentialDrive(**(given_values | {name: value}))


@pytest.mark.parametrize(
    "method", ["body_velocity", "wheel_speeds", "body_acceleration", "wheel_torques"]
)
def test_not_a_number_is_refused(method):
    drive = DifferentialDrive(wheel_radius=0.03, half_track=0.1, mass=1.0, inertia=0.01)
    with pytest.raises(InputError):
        getattr(drive, method)(math.nan, 0.0)
    with pytest.raises(InputError):
        getattr(drive, method)(0.0, math.inf)
