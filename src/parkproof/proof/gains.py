"""Gains together with the weights of their Lyapunov function, and the forms of the conditions."""

from dataclasses import dataclass
from enum import StrEnum

from parkproof.laws.gains import exponent
from parkproof.validate import positive


class Form(StrEnum):
    """How the last estimates of the proof are made; each form is sufficient by itself.

    Attributes
    ----------
    PRINTED
        Step 2: (16)(17) with the paper's extra factor 2^q. Step 3: (18)(19) as the scan is read.
    SHARP
        Step 2 only: (16)(17) without that factor.
    UNTUNED
        Step 3 only: (18')(19'), the same bound with Young's inequality taken at weight 1.

    Examples
    --------
    >>> from parkproof.proof.gains import Form
    >>> Form("sharp") is Form.SHARP
    True
    """

    PRINTED = "printed"
    SHARP = "sharp"
    UNTUNED = "untuned"


@dataclass(frozen=True)
class Step2Gains:
    """Gains and weights of Step 2, checked on creation.

    Parameters
    ----------
    q1 : float
        Exponent, in (2/3, 1).
    l1, l2, l3 : float
        Gains of the law τ̃2, positive.
    k1, k2 : float
        Weights of the Lyapunov function V3, positive; the law does not use them.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> from parkproof.proof.gains import Step2Gains
    >>> Step2Gains(q1=9 / 11, l1=2.0, l2=4.2, l3=21.0, k1=2.4, k2=17.5).l3
    21.0
    """

    q1: float
    l1: float
    l2: float
    l3: float
    k1: float
    k2: float

    def __post_init__(self) -> None:
        exponent("q1", self.q1, 2.0 / 3.0, "2/3")
        for name, example in (("l1", 2.0), ("l2", 4.2), ("l3", 21.0), ("k1", 2.4), ("k2", 17.5)):
            positive(name, getattr(self, name), example=example)


@dataclass(frozen=True)
class Step3Gains:
    """Gains and weight of Step 3, checked on creation.

    Parameters
    ----------
    q2 : float
        Exponent, in (1/2, 1).
    k1_tilde, k3_tilde : float
        Gains k̃1, k̃3 of the law τ̃1, positive.
    k2_tilde : float
        Weight k̃2 of the Lyapunov function, positive; the law does not use it.

    Raises
    ------
    InputError
        If a number is out of its range.

    Examples
    --------
    >>> from parkproof.proof.gains import Step3Gains
    >>> Step3Gains(q2=7 / 9, k1_tilde=1.5, k2_tilde=2.6, k3_tilde=6.5).k3_tilde
    6.5
    """

    q2: float
    k1_tilde: float
    k2_tilde: float
    k3_tilde: float

    def __post_init__(self) -> None:
        exponent("q2", self.q2, 0.5, "1/2")
        for name, example in (("k1_tilde", 1.5), ("k2_tilde", 2.6), ("k3_tilde", 6.5)):
            positive(name, getattr(self, name), example=example)
