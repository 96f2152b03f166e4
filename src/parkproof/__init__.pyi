"""Public names of parkproof, listed once: `__init__.py` loads them from here when used."""

from .bounds import Bounds as Bounds, Limits as Limits
from .references import citation as citation
from .errors import InputError as InputError
from .laws.chains import power_integrator_law as power_integrator_law
from .laws.controller import (
    Command as Command,
    Controller as Controller,
    Measurement as Measurement,
    measured_pose as measured_pose,
    measured_state as measured_state,
)
from .laws.gains import Gains as Gains, Switching as Switching
from .laws.robustify import robustify as robustify
from .model.camera import CeilingCamera as CeilingCamera, PinholeCamera as PinholeCamera
from .model.homography import Homography as Homography
from .model.chained import (
    ChainedState as ChainedState,
    from_chained as from_chained,
    to_chained as to_chained,
)
from .model.drive import DifferentialDrive as DifferentialDrive
from .model.overhead import HomographyTable as HomographyTable, PinholeTable as PinholeTable
from .model.signals import (
    Adversary as Adversary,
    Constant as Constant,
    Noise as Noise,
    Sine as Sine,
    Square as Square,
    Switched as Switched,
)
from .model.truth import Truth as Truth
from .model.unicycle import Pose as Pose, Velocity as Velocity
from .proof.conditions import check_conditions as check_conditions
from .proof.gains import Step2Gains as Step2Gains, Step3Gains as Step3Gains
from .proof.lyapunov import (
    settling_bound as settling_bound,
    step2_lyapunov as step2_lyapunov,
    step3_lyapunov as step3_lyapunov,
)
from .proof.remark3 import remark3_search as remark3_search
from .proof.search import remark4_search as remark4_search, sequential_search as sequential_search
from .proof.sphere import worst_ratio as worst_ratio
from .report.animation import animation as animation
from .report.figures import paper_figures as paper_figures, plot as plot
from .report.path_picture import path_picture as path_picture
from .results import (
    read_trajectory as read_trajectory,
    summary_of as summary_of,
    write_summary as write_summary,
    write_trajectory as write_trajectory,
)
from .scenario import (
    Robot as Robot,
    RunSettings as RunSettings,
    Scenario as Scenario,
    Start as Start,
    Weights as Weights,
)
from .scenario_file import read_scenario as read_scenario, template as template, to_toml as to_toml
from .paper_example import section4 as section4
from .simulation.ensemble import simulate_ensemble as simulate_ensemble
from .simulation.metrics import Metrics as Metrics
from .simulation.outcome import Outcome as Outcome
from .simulation.run import Run as Run, simulate as simulate

__version__: str
