"""Laws: pure scalar functions of a measurement and of what the controller may know."""

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.parameters import LawParameters, law_parameters


def default_parameters(*, implicit: bool = False) -> LawParameters:
    """Parameters of the paper's example (section 4), used throughout the documentation.

    Parameters
    ----------
    implicit : bool
        Whether for the implicit form.

    Returns
    -------
    LawParameters
        For α in [0.5, 1.5], γ in [1, 2], |φ| ≤ 2.5, the paper's gains, and a period of 1 ms.

    Examples
    --------
    >>> default_parameters().l3
    21.0
    """
    return law_parameters(
        bounds=Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5),
        gains=Gains(),
        switching=Switching(),
        control_period=1e-3,
        discretisation="implicit" if implicit else "explicit",
    )


def homogeneous_parameters(*, implicit: bool = False) -> LawParameters:
    """Parameters of the homogeneous law under the bounds of the paper's example.

    Parameters
    ----------
    implicit : bool
        Whether for the implicit form.

    Returns
    -------
    LawParameters
        With gains that keep |τ2| ≤ 20 at every state, and a period of 1 ms.

    Examples
    --------
    >>> homogeneous_parameters().feedback1
    -3.8494493
    """
    return law_parameters(
        bounds=Bounds(alpha=(0.5, 1.5), gamma=(1.0, 2.0), disturbance=2.5),
        gains=Gains(
            ellipsoid=(
                0.074812464,
                0.066401839,
                0.025390644,
                0.079551713,
                0.031872429,
                0.018868936,
            ),
            feedback=(-3.8494493, -5.1332745, -2.6799631),
        ),
        switching=Switching(),
        control_period=1e-3,
        discretisation="implicit" if implicit else "explicit",
    )
