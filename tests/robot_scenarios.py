"""Scenarios of robots of every kind under cameras of several kinds."""

from typing import Any

import msgspec

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains
from parkproof.model.overhead import HomographyTable, Overhead, PinholeTable
from parkproof.model.signals import Adversary, Sine, Square
from parkproof.model.truth import Truth
from parkproof.scenario import Robot, RunSettings, Scenario, Start

PERIOD = 5e-3
TILTED = PinholeTable(
    height=3.0, focal_length=380.0, tilt_deg=20.0, roll_deg=20.0, aspect=1.1, unit=120.0,
    goal=(0.3, 0.2, 0.4),
)  # fmt: skip
ROLLED = PinholeTable(
    height=3.0, focal_length=300.0, tilt_deg=15.0, roll_deg=-120.0, unit=90.0, goal=(0.2, 0.1, 0.2)
)
GIVEN = HomographyTable(matrix=TILTED.view.to_pixels.entries, unit=110.0, goal=(0.1, 0.1, 0.3))
CAMERAS: tuple[Overhead, ...] = (TILTED, ROLLED, GIVEN)
POSES = (
    (-0.8, 0.3, 0.2), (0.5, -0.3, -0.7), (-0.5, 0.2, 2.0), (-0.4, 0.1, -3.1), (0.1, 0.1, 1.45),
    (-1.0, -0.3, 0.0),
)  # fmt: skip
SINES = Truth(
    gamma=(Sine(mean=1.25, amplitude=0.25, omega=3.0), Sine(mean=1.2, amplitude=0.2, omega=2.0)),
    disturbance=(Sine(amplitude=0.5, omega=3.0), Sine(amplitude=0.4, omega=2.0)),
)
TRUTHS = (
    SINES,
    Truth(gamma=(Adversary(), Adversary()), disturbance=(Adversary(), Adversary())),
    Truth(
        gamma=SINES.gamma,
        disturbance=(Square(amplitude=0.4, omega=9.0), Sine(amplitude=0.3, omega=2.0)),
    ),
)
HOMOGENEOUS = Gains(
    ellipsoid=(0.074812464, 0.066401839, 0.025390644, 0.079551713, 0.031872429, 0.018868936),
    feedback=(-3.8494493, -5.1332745, -2.6799631),
)

COMBINATIONS = [
    ("torque", False, "corrected", "explicit", False),
    ("torque", True, "published", "implicit", True),
    ("velocity", True, "corrected", "implicit", False),
    ("velocity", False, "homogeneous", "explicit", True),
    ("chained", True, "corrected", "explicit", False),
    ("chained", True, "homogeneous", "implicit", True),
]
"""Robot, camera, law, form, noise with latency: each pair of them occurs, and each is a kernel."""


def scenario(
    robot: str, camera: Overhead | None, law: str, form: str, noisy: bool, **changes: Any
) -> Scenario:
    run = {"duration": 0.3, "control_period": PERIOD, "discretisation": form}
    run |= {"noise": 1e-4, "latency": 2 * PERIOD} if noisy else {}
    run |= {name: changes.pop(name) for name in RunSettings.__struct_fields__ if name in changes}
    own = robot == "velocity"
    known = {} if own else {"gamma": (1.0, 1.5), "disturbance": 0.5}
    truth = changes.pop("truth", SINES)
    truth = Truth() if own else truth
    if camera is None:
        truth = msgspec.structs.replace(truth, alpha=(0.7, 1.3))
    gains = {"published": Gains(), "homogeneous": HOMOGENEOUS}.get(law, Gains(runup_speed=0.5))
    settings: dict[str, Any] = {
        "law": law,
        "bounds": Bounds(alpha=(0.3, 2.5), **known),  # type: ignore[arg-type]  # of two kinds
        "truth": truth,
        "gains": gains,
        "robot": Robot(kind=robot),  # type: ignore[arg-type]  # names of kinds
        "camera": camera,
        "run": RunSettings(**run),  # type: ignore[arg-type]  # of several kinds
    }
    return Scenario(**(settings | changes))


def trials(
    robot: str, camera: bool, law: str, form: str, noisy: bool, **changes: Any
) -> list[Scenario]:
    """Starts in the chart and, for laws that turn, outside it, each under another camera."""
    return [
        scenario(
            robot,
            CAMERAS[i % 3] if camera else None,
            law,
            form,
            noisy,
            start=Start(pose=pose, velocity=(0.2, 0.1)),
            truth=TRUTHS[i % 3],
            seed=i,
            **changes,
        )
        for i, pose in enumerate(POSES)
        if law != "published" or abs(pose[2]) < 1.4
    ]
