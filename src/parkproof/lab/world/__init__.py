"""A laboratory in the computer: MuJoCo's physics, rendered off-screen, with simulated time."""

from parkproof.lab.world.camera_settings import CameraSettings as CameraSettings
from parkproof.lab.world.floor_settings import FloorSettings as FloorSettings
from parkproof.lab.world.pushes import PushSettings as PushSettings
from parkproof.lab.world.random_world import random_world as random_world
from parkproof.lab.world.robot_settings import RobotSettings as RobotSettings
from parkproof.lab.world.settings import WorldSettings as WorldSettings
from parkproof.lab.world.truth import Truth as Truth
from parkproof.lab.world.world import World as World
