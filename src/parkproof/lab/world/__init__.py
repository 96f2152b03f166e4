"""A laboratory in the computer: MuJoCo's physics, rendered off-screen, with simulated time."""

from parkproof.lab.world.random_world import random_world as random_world
from parkproof.lab.world.settings import CameraSettings as CameraSettings
from parkproof.lab.world.settings import FloorSettings as FloorSettings
from parkproof.lab.world.settings import PushSettings as PushSettings
from parkproof.lab.world.settings import RobotSettings as RobotSettings
from parkproof.lab.world.settings import WorldSettings as WorldSettings
from parkproof.lab.world.world import Truth as Truth
from parkproof.lab.world.world import World as World
