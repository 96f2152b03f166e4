"""The claims of the paper, each beside what happens when it is run."""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from parkproof.paper_example import BOUNDS, GAINS, START, SWITCH_OF_FIGURES
from parkproof.proof.conditions import Condition
from parkproof.report.evidence import SMALL_GAINS, Evidence, Redivergence
from parkproof.simulation.run import Run

AT_REST = 0.02
"""A state counts as at zero below this."""


class Verdict(Enum):
    """What is to be said of a claim."""

    HOLDS = "holds"
    FAILS = "fails"
    OPEN = "cannot be decided"


@dataclass(frozen=True)
class Claim:
    """One row of the table of claims.

    Attributes
    ----------
    claim : str
        What the paper says.
    where : str
        Where it says so.
    measured : str
        What we measured.
    verdict : Verdict
        Whether it holds.
    """

    claim: str
    where: str
    measured: str
    verdict: Verdict


def _holds(condition: bool) -> Verdict:
    return Verdict.HOLDS if condition else Verdict.FAILS


def _range(times: list[float]) -> str:
    return f"{min(times):.1f} to {max(times):.1f}" if times else "no"


def largest_in_step3(run: Run) -> float:
    """Largest |x1| during Step 3.

    Parameters
    ----------
    run : Run
        A run that reached Step 3.

    Returns
    -------
    float
        The largest |x1|; 0 if there was no Step 3.

    Examples
    --------
    >>> from parkproof.paper_example import section4
    >>> from parkproof.simulation.run import simulate
    >>> largest_in_step3(simulate(section4(duration=0.1)))
    0.0
    """
    inside = run.trajectory["step"] == 3
    return float(np.max(np.abs(run.trajectory["x1"][inside]), initial=0.0))


def _at(run: Run, name: str, t: float) -> float:
    return float(run.trajectory[name][np.searchsorted(run.trajectory["t"], t - 1e-9)])


def _values(conditions: tuple[Condition, ...]) -> str:
    return ", ".join(f"{c.name} {_signed(c.value)}" for c in conditions)


def _signed(value: float) -> str:
    return f"{value:+.2f}".replace("-", "−")


def claims_of(evidence: Evidence) -> list[Claim]:
    """Compare the paper's claims with the evidence.

    Parameters
    ----------
    evidence : Evidence
        From `parkproof.report.evidence.gather`.

    Returns
    -------
    list of Claim
        In the order of the paper.

    Examples
    --------
    >>> claims_of(evidence)[0].verdict
    <Verdict.FAILS: 'fails'>
    """
    return [
        *_of_the_model(evidence),
        *_of_the_steps(evidence),
        *_of_the_conditions(evidence),
        *_of_the_figures(evidence),
    ]


def _of_the_model(evidence: Evidence) -> list[Claim]:
    low, high = BOUNDS.gamma_of(0)
    turned = evidence.turned
    parked = turned.settling_time.total
    unequal = [time for (alpha, _), time in evidence.step2_times.items() if alpha != 1.0]
    settled = [time for time in unequal if time is not None]
    return [
        Claim(
            "The stabilization is global.",
            "title",
            "Global in the chained coordinates only: x2 = tan θ exists for |θ| < 90°, and a start "
            "at 170° has no chained state. Turning first mends it: the corrected law "
            + (
                f"parks that start in {parked:.1f} s."
                if parked is not None
                else "does not park that start either."
            ),
            Verdict.FAILS,
        ),
        Claim(
            "The controller handles an uncertain control direction.",
            "abstract, (6)",
            f"γ_i(t) is bounded by [{low:g}, {high:g}], so its sign, the direction, is known; what "
            "is uncertain is the size of the gain.",
            Verdict.FAILS,
        ),
        Claim(
            "The disturbances are unmatched.",
            "abstract, (6)",
            "φ_i enters (6) in the same equation as τ_i: they are matched, and Theorem 1 needs "
            "them to be.",
            Verdict.FAILS,
        ),
        Claim(
            "Unequal image scales need no calibration (α1 ≠ α2).",
            "Remark 1",
            f"With α1 = 1 and α2 = 0.5 and 1.5, Step 2 settled in {len(settled)} of {len(unequal)} "
            f"runs (sines, adversary), in {_range(settled)} s. But the law is fed the metric "
            "heading, which with α1 ≠ α2 the image does not show (D6).",
            Verdict.OPEN if len(settled) == len(unequal) else Verdict.FAILS,
        ),
    ]


def _of_the_steps(evidence: Evidence) -> list[Claim]:
    error = abs(START[3] - 1.0)
    rest = 1.0 - GAINS.exponents[0]
    bound = error**rest / (GAINS.lambda1 * rest)
    sines = evidence.figures["published"].settling_time.steps["1"] or float("nan")
    worst = evidence.worst_step1.settling_time.steps["1"] or float("nan")
    angles = {law: _largest_heading(run, 1) for law, run in evidence.pushed.items()}
    times = list(evidence.step2_times.values())
    slowest = max((t for t in times if t is not None), default=float("nan"))
    published = evidence.figures["published"]
    end3 = published.settling_time.steps["3"]
    bounds = "; ".join(
        f"{bound:.1f} s for q1 = {q1} (the undisturbed run: {_seconds(time)})"
        for q1, (bound, time) in evidence.bounds.items()
    )
    return [
        Claim(
            "Step 1 brings u0 to 1 within T1 = |u0(0) − 1|^(1−q0)/(λ1(1−q0)).",
            "(20)",
            f"Bound {bound:.3f} s; measured {worst:.3f} s under the adversary that exhausts the "
            f"bounds, {sines:.3f} s under sines.",
            _holds(worst <= bound and sines <= bound),
        ),
        Claim(
            "Step 1 needs no control of (x2, u1): τ2 = 0.",
            "section 3, Step 1",
            "With the largest constant φ2 and the slowest Step 1 the heading went to "
            f"{angles['published']:.1f}° in Step 1; the larger φ2 or T1, the nearer to 90°. Under "
            f"the corrected law, which holds (x2, u1) there, it never exceeded "
            f"{angles['corrected']:.1f}°, with which it started (D8).",
            Verdict.OPEN,
        ),
        Claim(
            "Step 2 brings (x1, x2, u1) to zero in finite time.",
            "Theorem 2, Step 2",
            f"{sum(t is not None for t in times)} of {len(times)} runs settled to 0.01 (α2 = 0.5, "
            f"1, 1.5; sines and adversary), in at most {slowest:.1f} s. Measured, not proved; for "
            "what was sampled see the row on V3.",
            _holds(None not in times),
        ),
        Claim(
            "Step 3 brings (x0, u0) to zero in finite time.",
            "Theorem 2, Step 3",
            f"Reached 0.01 at t = {end3:.1f} s, {end3 - SWITCH_OF_FIGURES:.1f} s after the switch. "
            "Measured, not proved."
            if end3 is not None
            else "Not reached.",
            _holds(end3 is not None),
        ),
        _redivergence(evidence.redivergence),
        _stop(published),
        Claim(
            "Bounds of the settling time are challenging to give.",
            "Remark 5",
            "Homogeneity gives them once V̇3 ≤ −cV3^α is known. For Step 2 from (1, 0, 0) with "
            f"α2 = 0.5 the sampled c gives {bounds}. Sampled, not proved.",
            Verdict.OPEN,
        ),
    ]


def _seconds(time: float | None) -> str:
    return "not settled" if time is None else f"{time:.1f} s"


def _largest_heading(run: Run, step: int) -> float:
    inside = run.trajectory["step"] == step
    return float(np.degrees(np.max(np.abs(run.trajectory["theta"][inside]))))


def _redivergence(found: list[Redivergence]) -> Claim:
    parts = [
        f"{largest_in_step3(entry.runs['published']):.2f} (corrected law "
        f"{largest_in_step3(entry.runs['corrected']):.0e})"
        for entry in found
    ]
    tolerances = ", ".join(f"{entry.tolerance:g}" for entry in found)
    stays = all(
        largest_in_step3(entry.runs["published"]) <= 10.0 * entry.tolerance for entry in found
    )
    return Claim(
        "(x1, x2, u1) stay at zero in Step 3, τ2 being that of Step 2.",
        "section 3, Step 3",
        f"Started with |x1|, |x2|, |u1| ≤ {tolerances}, |x1| reached {', '.join(parts)}: u0 turns "
        "negative while τ̃2 assumes u0 > 0, and the origin becomes unstable (D3).",
        _holds(stays),
    )


def _stop(published: Run) -> Claim:
    end3 = published.settling_time.steps["3"]
    final = published.metrics.final
    return Claim(
        "After T3 both inputs can be set to zero: the robot has stopped.",
        "section 3, after Step 3",
        f"From t = {end3:.1f} s to {published.ended:.0f} s the disturbance drove x0 from "
        f"{_at(published, 'x0', end3):.3f} to {final['x0']:.1f} and u0 to {final['u0']:.1f}: "
        "against a disturbance that persists the law must go on holding."
        if end3 is not None
        else "Step 3 did not end.",
        _holds(end3 is not None and max(abs(final["x0"]), abs(final["u0"])) <= AT_REST),
    )


def _of_the_conditions(evidence: Evidence) -> list[Claim]:
    remark3, sequential = evidence.remark3, evidence.sequential.gains
    small = evidence.sequential_small.gains
    paper = {q: r for (q, weights), r in evidence.ratios.items() if weights == "paper"}
    other = {q: -r for (q, weights), r in evidence.ratios.items() if weights == "other"}
    passes = " → ".join(f"{step.l:.3g}" for step in remark3.passes[:4])
    return [
        Claim(
            "The gains of section 4 satisfy (15)-(17).",
            "section 4",
            f"Each must be negative. As printed: {_values(evidence.printed)}; in the sharp form: "
            f"{_values(evidence.sharp)} (q1 = 9/11). No other reading of the decimal points of k1 "
            f"and k2 mends (16): it stays above {_signed(evidence.readings)} at 40 values of q1.",
            _holds(all(c.holds for c in evidence.printed)),
        ),
        Claim(
            "The gains of section 4 satisfy (18) and (19).",
            "section 4",
            f"{_values(evidence.step3)} (q2 = 7/9); in the untuned form {_values(evidence.untuned)}"
            ". Read from a damaged scan.",
            _holds(all(c.holds for c in evidence.step3)),
        ),
        Claim(
            "V3 with the weights k1, k2 of section 4 decreases along Step 2.",
            "section 4, Theorem 2",
            "Largest V̇3/V3^α found on the homogeneous sphere: "
            + ", ".join(f"{_signed(r)} (q1 = {q})" for q, r in paper.items())
            + ". A positive value is a counterexample. With other weights, which are no part of "
            "the law, the same gains pass the sampling with c = "
            + ", ".join(f"{c:.2f} (q1 = {q})" for q, c in other.items())
            + ": sampled, not proved.",
            _holds(all(r < 0.0 for r in paper.values())),
        ),
        Claim(
            "Gains of about the size that (15)-(17) ask for are needed.",
            "not claimed; Theorem 2 is sufficient only",
            f"With l = (0.67, 1.09, 3.9) and q1 = 13/15, V̇3 ≤ −{-evidence.small_ratio:.2f} V3^α "
            f"wherever sampled; the sharp conditions need l3 = {small.l3:.0f} there, "
            f"{small.l3 / SMALL_GAINS.l[2]:.0f} times as much. Sampled, not proved.",
            Verdict.OPEN,
        ),
        Claim(
            "The search of Remark 3 finds feasible gains.",
            "Remark 3",
            f"From l = {passes} it never ends: l̄2/l ≥ {remark3.smallest_ratio:.1f} for every l, "
            f"and l̄2 grows like l^{remark3.growth_exponent:.2f}. Choosing l1, k1, l2, k2, l3 in "
            f"turn does: l = ({sequential.l1:.2f}, {sequential.l2:.2f}, {sequential.l3:.0f}).",
            _holds(remark3.found is not None),
        ),
        Claim(
            "k̃1, k̃2, k̃3 can be chosen in turn.",
            "Remark 4",
            f"For k̃1 = {evidence.remark4.gains.k1_tilde:g}: k̃2 = "
            f"{evidence.remark4.gains.k2_tilde:.2f}, k̃3 = {evidence.remark4.gains.k3_tilde:.1f}.",
            _holds(all(c.holds for c in evidence.remark4.conditions)),
        ),
    ]


def _of_the_figures(evidence: Evidence) -> list[Claim]:
    run = evidence.figures["published"]
    late = run.trajectory["t"] > SWITCH_OF_FIGURES
    peak = float(np.min(run.trajectory["u0"][late]))
    approach = run.trajectory["step"] == 2
    off = float(np.max(np.abs(run.trajectory["u0"][approach] - 1.0)))
    lateral = max(abs(_at(run, name, SWITCH_OF_FIGURES)) for name in ("x1", "x2", "u1"))
    farthest = float(np.max(np.abs(run.trajectory["xm"][late])))
    rest = run.metrics.residual_by_state
    fast = evidence.figures["corrected_fast"].metrics.max_abs["x0"]
    end3 = run.settling_time.steps["3"]
    x0_end = run.metrics.final["x0"]
    before = run.trajectory["t"] < SWITCH_OF_FIGURES
    peaks = [float(np.max(np.abs(run.trajectory[n][before]))) for n in ("tau1", "tau2")]
    reached = f"x0 and u0 first reach 0.01 at {end3:.1f} s" if end3 is not None else "not reached"
    return [
        Claim(
            "Figure 3: (x0, u0) goes to zero in t < 35 s.",
            "Fig. 3",
            f"{reached}, as claimed; after the stop they do not stay there: x0 = {x0_end:.1f} at "
            "35 s, with our choice of φ.",
            _holds(max(abs(x0_end), abs(run.metrics.final["u0"])) <= AT_REST),
        ),
        Claim(
            "Figure 3: u0 stays at 1 until Step 3 and has a peak at the switch, t = 25 s.",
            "Fig. 3",
            f"|u0 − 1| ≤ {off:.4f} throughout Step 2; the peak after the switch is "
            f"{peak:.1f}.".replace("-", "−"),
            _holds(off < 0.02 and abs(peak) > 1.0),
        ),
        Claim(
            "Figure 4: x1, x2, u1 are stabilised to zero within [0, 35] s.",
            "Fig. 4",
            f"None exceeds {lateral:.0e} when Step 3 begins; in Step 3 |x1| reaches "
            f"{largest_in_step3(run):.3g}, and at 35 s it is {abs(run.metrics.final['x1']):.3g}.",
            _holds(max(rest[name] for name in ("x1", "x2", "u1")) <= AT_REST),
        ),
        Claim(
            "Figure 5: the inputs stay within about 20.",
            "Fig. 5 (axis)",
            f"Before Step 3: peak |τ1| {peaks[0]:.0f}, |τ2| {peaks[1]:.0f}, with our choice of "
            "α, γ and φ; the paper's were not published.",
            Verdict.OPEN,
        ),
        Claim(
            "The robot stays in the camera's view.",
            "not treated; Fig. 6",
            f"From 0.3 units aside, x_m went to {farthest:.1f} units, as Step 2 ran at u0 = 1 "
            f"until 25 s, and to {fast:.1f} under the corrected law, which goes on as soon as it "
            "can. The view's size was not published.",
            Verdict.OPEN,
        ),
        Claim(
            "Figures 6-8: x_m, y_m and θ go to zero in finite time.",
            "Figs. 6-8",
            f"In the last 2 s |x_m| is up to {rest['x0']:.3g}, |y_m| up to {rest['x1']:.3g} and "
            f"|θ| up to {np.degrees(np.arctan(rest['x2'])):.3g}°.",
            _holds(max(rest[name] for name in ("x0", "x1", "x2")) <= AT_REST),
        ),
        Claim(
            "The curves of Figures 3 to 8, point by point.",
            "Figs. 3-8",
            "The true α_i, γ_i(t), φ_i(t) were not published and q0, q1, q2 cannot be read in the "
            "scan, so the curves cannot be compared, only what they show.",
            Verdict.OPEN,
        ),
    ]
