"""Everything that is run and computed for the reproduction of the paper, before it is drawn."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from msgspec.structs import replace

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.laws.parameters import Discretisation
from parkproof.model.signals import Adversary, Constant
from parkproof.model.truth import Truth
from parkproof.paper_example import BOUNDS, GAINS, SIGNALS, SWITCH_OF_FIGURES, WEIGHTS, section4
from parkproof.proof.conditions import Condition, check_conditions
from parkproof.proof.gains import Step2Gains, Step3Gains
from parkproof.proof.lyapunov import settling_bound, step2_lyapunov
from parkproof.proof.remark3 import Remark3Result, remark3_search
from parkproof.proof.search import Step2Found, Step3Found, remark4_search, sequential_search
from parkproof.proof.sphere import worst_ratio
from parkproof.scenario import Start
from parkproof.simulation.run import Run, simulate

LawName = Literal["published", "corrected"]
LAWS: tuple[LawName, ...] = ("published", "corrected")
FORMS: tuple[Discretisation, ...] = ("explicit", "implicit")

FORWARD = replace(GAINS, direction="forward")
"""The corrected law driven as the paper drives, for figures side by side."""

ADVERSARY = Truth(gamma=(Adversary(), Adversary()), disturbance=(Adversary(), Adversary()))
PUSH = Truth(gamma=(Adversary(), Adversary()), disturbance=(Adversary(), Constant(2.5)))
"""Channel 2 pushed with the largest constant disturbance: what Step 1 leaves uncontrolled."""

TOLERANCES = (1e-2, 1e-3, 1e-4)
ALPHA_CORNERS = (0.5, 1.0, 1.5)
EXPONENTS = ("7/9", "9/11", "13/15", "19/21")
OTHER_WEIGHTS = {
    "7/9": (9.34, 1153.0),
    "9/11": (4.28, 311.0),
    "13/15": (2.71, 79.6),
    "19/21": (3.52, 58.9),
}
"""Weights k1, k2 with which the published l1, l2, l3 pass the sampling."""

SMALL_GAINS = Gains(q1="13/15", l=(0.67, 1.09, 3.9))
SMALL_WEIGHTS = (0.245, 0.172)
PERIODS = (0.001, 0.002, 0.005, 0.01, 0.02, 0.033)
PLANT_STEPS = (1e-3, 5e-4)
FINEST_PLANT_STEP = 2.5e-4


@dataclass(frozen=True, kw_only=True)
class Redivergence:
    """Step 3 started at a tolerance, under both laws."""

    tolerance: float
    runs: dict[LawName, Run]


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """What was run and computed.

    Attributes
    ----------
    figures : dict of str to Run
        "published" and "corrected" with Step 3 at 25 s, and "corrected_fast".
    redivergence : list of Redivergence
        Step 3 as soon as settled, for three tolerances.
    worst_step1 : Run
        Step 1 of the published law under the adversary.
    step2_times : dict
        (α2, "sines" or "adversary") → duration of Step 2 of the published law in s with α1 = 1,
        None where it did not settle.
    pushed : dict of str to Run
        Step 1 of both laws with channel 2 pushed by the largest constant disturbance.
    turned : Run
        The corrected law started at a heading of 170°.
    printed, sharp, step3, untuned : tuple of Condition
        (15)-(17) as printed and sharp, (18)-(19) as printed and untuned, at the published gains.
    ratios : dict
        (q1, "paper" or "other") → largest sampled V̇3/V3^α with the paper's weights or others.
    small_ratio : float
        The same for gains some 50 times smaller than the conditions ask for.
    bounds : dict
        q1 → (settling time of Step 2 from (1, 0, 0) that the sampled rate would bound, the time
        that the undisturbed run took to 1e-4), both in s for α2 = 0.5.
    readings : float
        Smallest value of (16) over the decimal-point readings of k1, k2 and all q1.
    remark3, sequential, remark4
        Results of the searches.
    sequential_small
        The search at the exponent of the small gains.
    plant_errors : dict of float to float
        Integration step of the plant → largest difference of the first 3 s from the finest.
    residuals : dict
        (period, discretisation) → (residual, total variation of τ2 per second, outcome).
    """

    figures: dict[str, Run]
    redivergence: list[Redivergence]
    worst_step1: Run
    step2_times: dict[tuple[float, str], float | None]
    pushed: dict[LawName, Run]
    turned: Run
    printed: tuple[Condition, ...]
    sharp: tuple[Condition, ...]
    step3: tuple[Condition, ...]
    untuned: tuple[Condition, ...]
    ratios: dict[tuple[str, str], float]
    small_ratio: float
    bounds: dict[str, tuple[float, float | None]]
    readings: float
    remark3: Remark3Result
    sequential: Step2Found
    sequential_small: Step2Found
    remark4: Step3Found
    plant_errors: dict[float, float]
    residuals: dict[tuple[float, str], tuple[float, float, str]]


def figure_runs(laws: tuple[str, ...]) -> dict[str, Run]:
    """Carry out the runs that Figures 3 to 8 show.

    Parameters
    ----------
    laws : tuple of str
        "published", "corrected" or both.

    Returns
    -------
    dict of str to Run
        Named as their directories: published, corrected, corrected_fast.

    Examples
    --------
    >>> list(figure_runs(("corrected",)))
    ['corrected', 'corrected_fast']
    """
    at_25 = Switching(to_step3=SWITCH_OF_FIGURES)
    runs = {}
    if "published" in laws:
        runs["published"] = simulate(section4("published", switching=at_25, title="Section 4"))
    if "corrected" in laws:
        runs["corrected"] = simulate(
            section4(
                "corrected",
                gains=FORWARD,
                switching=at_25,
                title="Section 4, Step 3 at 25 s",
            )
        )
        runs["corrected_fast"] = simulate(
            section4("corrected", title="Section 4, as fast as it goes")
        )
    return runs


def _redivergence() -> list[Redivergence]:
    found = []
    for tolerance in TOLERANCES:
        switching = Switching(tolerance=(1e-3, tolerance, 1e-2))
        runs: dict[LawName, Run] = {
            law: simulate(section4(law, gains=FORWARD, switching=switching, duration=8.0))
            for law in LAWS
        }
        found.append(Redivergence(tolerance=tolerance, runs=runs))
    return found


def _step2_times() -> dict[tuple[float, str], float | None]:
    """How long Step 2 takes from the state in which Step 1 leaves (x1, x2, u1)."""
    times: dict[tuple[float, str], float | None] = {}
    for alpha in ALPHA_CORNERS:
        for name, truth in (("sines", SIGNALS), ("adversary", ADVERSARY)):
            scaled = replace(truth, alpha=(1.0, alpha))
            run = simulate(section4("published", truth=scaled, duration=11.0))
            first, second = run.settling_time.steps["1"], run.settling_time.steps["2"]
            times[alpha, name] = None if first is None or second is None else second - first
    return times


def _ratios() -> dict[tuple[str, str], float]:
    alpha = BOUNDS.alpha_of(1)
    return {
        (q1, name): worst_ratio(step2_lyapunov(Gains(q1=q1, l=GAINS.l), k=k), alpha=alpha).ratio
        for q1 in EXPONENTS
        for name, k in (("paper", WEIGHTS.k), ("other", OTHER_WEIGHTS[q1]))
    }


def _bounds(ratios: dict[tuple[str, str], float]) -> dict[str, tuple[float, float | None]]:
    """Bound and measured time of an undisturbed Step 2 from (1, 0, 0) with α2 = 0.5."""
    found: dict[str, tuple[float, float | None]] = {}
    for q1 in ("9/11", "13/15"):
        gains = Gains(q1=q1, l=GAINS.l)
        value = step2_lyapunov(gains, k=OTHER_WEIGHTS[q1]).value(1.0, 0.0, 0.0, alpha=0.5)
        exponent = 0.5 * (1.0 + gains.exponents[1])
        scenario = section4(
            "published",
            gains=gains,
            truth=Truth(alpha=(1.0, 0.5)),
            start=Start(state=(0.0, 1.0, 0.0, 1.0, 0.0)),
            switching=Switching(tolerance=(1e-3, 1e-4, 1e-2)),
            discretisation="implicit",
            duration=9.0,
        )
        run = simulate(replace(scenario, bounds=Bounds(alpha=BOUNDS.alpha)))
        bound = settling_bound(float(value), c=-ratios[q1, "other"], exponent=exponent)
        found[q1] = bound, run.settling_time.steps["2"]
    return found


def _readings() -> float:
    """Smallest value of (16), printed and sharp, over readings of k1, k2 and exponents."""
    l1, l2, l3 = GAINS.l
    return min(
        check_conditions(
            Step2Gains(q1=float(q1), l1=l1, l2=l2, l3=l3, k1=k1, k2=k2),
            alpha_max=BOUNDS.alpha_of(1)[1],
            form=form,
        )[1].value
        for q1 in np.linspace(0.67, 0.995, 40)
        for k1 in (0.24, 2.4, 24.0)
        for k2 in (1.75, 17.5, 175.0)
        for form in ("printed", "sharp")
    )


def _plant_errors() -> dict[float, float]:
    """Largest difference of any state over the first 3 s from a run with the finest plant step."""
    runs = {}
    for step in (*PLANT_STEPS, FINEST_PLANT_STEP):
        scenario = section4("corrected", discretisation="implicit", duration=3.0)
        runs[step] = simulate(replace(scenario, run=replace(scenario.run, plant_step=step)))
    finest = runs.pop(FINEST_PLANT_STEP).trajectory
    return {
        step: max(
            float(np.max(np.abs(run.trajectory[name] - finest[name])))
            for name in ("x0", "x1", "x2", "u0", "u1")
        )
        for step, run in runs.items()
    }


def _residuals() -> dict[tuple[float, str], tuple[float, float, str]]:
    found: dict[tuple[float, str], tuple[float, float, str]] = {}
    for period in PERIODS:
        for form in FORMS:
            scenario = section4(
                "corrected",
                control_period=period,
                discretisation=form,
                switching=Switching(tolerance=(0.02, 0.05, 0.05)),
                duration=12.0,
            )
            run = simulate(scenario)
            late = run.trajectory["t"] >= 10.0
            chatter = float(np.sum(np.abs(np.diff(run.trajectory["tau2"][late])))) / 2.0
            found[period, form] = (run.metrics.residual, chatter, run.outcome.value)
    return found


def gather(
    figures: dict[str, Run], *, progress: Callable[[str], None] = lambda _: None
) -> Evidence:
    """Run and compute everything else that the claims need.

    Parameters
    ----------
    figures : dict of str to Run
        From `figure_runs`, for both laws.
    progress : callable
        Told what is being done.

    Returns
    -------
    Evidence
        See there.

    Examples
    --------
    >>> evidence = gather(figure_runs(LAWS))
    >>> [entry.tolerance for entry in evidence.redivergence]
    [0.01, 0.001, 0.0001]
    """
    l1, l2, l3 = GAINS.l
    q1, q2 = GAINS.exponents[1], GAINS.exponents[2]
    alpha1_max, alpha2_max = BOUNDS.alpha_of(0)[1], BOUNDS.alpha_of(1)[1]
    step2_gains = Step2Gains(q1=q1, l1=l1, l2=l2, l3=l3, k1=WEIGHTS.k[0], k2=WEIGHTS.k[1])
    step3_gains = Step3Gains(
        q2=q2, k1_tilde=GAINS.k[0], k2_tilde=WEIGHTS.k_step3, k3_tilde=GAINS.k[1]
    )
    progress("Step 3, started at three tolerances")
    redivergence = _redivergence()
    progress("worst cases of Steps 1 and 2")
    worst_step1 = simulate(section4("published", truth=ADVERSARY, duration=4.5))
    step2_times = _step2_times()
    pushed: dict[LawName, Run] = {
        law: simulate(section4(law, gains=FORWARD, truth=PUSH, duration=4.5)) for law in LAWS
    }
    turned = simulate(
        section4("corrected", start=Start(pose=(-0.2, 0.3, np.radians(170.0))), duration=12.0)
    )
    progress("conditions and searches for gains")
    ratios = _ratios()
    progress("convergence study")
    return Evidence(
        figures=figures,
        redivergence=redivergence,
        worst_step1=worst_step1,
        step2_times=step2_times,
        pushed=pushed,
        turned=turned,
        printed=check_conditions(step2_gains, alpha_max=alpha2_max, form="printed"),
        sharp=check_conditions(step2_gains, alpha_max=alpha2_max, form="sharp"),
        step3=check_conditions(step3_gains, alpha_max=alpha1_max, form="printed"),
        untuned=check_conditions(step3_gains, alpha_max=alpha1_max, form="untuned"),
        ratios=ratios,
        small_ratio=worst_ratio(
            step2_lyapunov(SMALL_GAINS, k=SMALL_WEIGHTS), alpha=BOUNDS.alpha_of(1)
        ).ratio,
        bounds=_bounds(ratios),
        readings=_readings(),
        remark3=remark3_search(q1, alpha_max=alpha2_max),
        sequential=sequential_search(q1, alpha_max=alpha2_max, form="sharp"),
        sequential_small=sequential_search(
            SMALL_GAINS.exponents[1], alpha_max=alpha2_max, form="sharp"
        ),
        remark4=remark4_search(q2, GAINS.k[0], alpha_max=alpha1_max),
        plant_errors=_plant_errors(),
        residuals=_residuals(),
    )
