"""The paper's example (section 4), as far as it was published.

The true α_i, γ_i(t) and φ_i(t) were not: the ones here are a choice inside the published bounds.
The exponents cannot be read in the scan; 1/3, 9/11 and 7/9 are this project's choice.
"""

from typing import Literal

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.parameters import Discretisation
from parkproof.model.signals import Sine
from parkproof.model.truth import Truth
from parkproof.scenario import RunSettings, Scenario, Start, Weights

BOUNDS = Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5)
GAINS = Gains(q0="1/3", q1="9/11", q2="7/9", lambda1=1.0, l=(2.0, 4.2, 21.0), k=(1.5, 6.5))
WEIGHTS = Weights(k=(2.4, 17.5), k_step3=2.6)
START = (-0.2, 0.3, -0.5, 5.6, 0.8)
QUARTER_TURN = 1.5708
SIGNALS = Truth(
    alpha=(1.0, 1.0),
    gamma=(
        Sine(mean=1.5, amplitude=0.5, omega=1.0),
        Sine(mean=1.5, amplitude=0.5, omega=1.0, phase=QUARTER_TURN),
    ),
    disturbance=(
        Sine(amplitude=2.5, omega=1.0),
        Sine(amplitude=2.5, omega=1.0, phase=QUARTER_TURN),
    ),
)
SWITCH_OF_FIGURES = 25.0
"""When the paper's figures go to Step 3, in s."""


def section4(
    law: Literal["published", "corrected"] = "published",
    *,
    gains: Gains = GAINS,
    truth: Truth = SIGNALS,
    switching: Switching | None = None,
    start: Start | None = None,
    duration: float = 35.0,
    control_period: float = 1e-3,
    discretisation: Discretisation = "explicit",
    title: str = "Section 4",
) -> Scenario:
    """Make the scenario of the paper's section 4, or a variation of it.

    Parameters
    ----------
    law : "published" or "corrected"
        The law.
    gains, truth, switching, start
        Replacements for the paper's, or for this project's choice.
    duration, control_period : float
        Length of the run and period of the controller, in s.
    discretisation : "explicit" or "implicit"
        Form of the law in sampled time.
    title : str
        Title of the scenario.

    Returns
    -------
    Scenario
        Ready for `parkproof.simulate`.

    Examples
    --------
    >>> section4().bounds.disturbance
    (2.5, 2.5)
    """
    return Scenario(
        title=title,
        law=law,
        bounds=BOUNDS,
        gains=gains,
        weights=WEIGHTS,
        truth=truth,
        start=start or Start(state=START),
        switching=switching or Switching(),
        run=RunSettings(
            duration=duration, control_period=control_period, discretisation=discretisation
        ),
    )
