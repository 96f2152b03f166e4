"""What is measured beside a proof: runs in sampled time under truths that strain the law."""

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.bounds import Bounds
from parkproof.laws.gains import Gains, Switching
from parkproof.scenario import RunSettings, Scenario, Start
from parkproof.simulation.ensemble import simulate_ensemble
from parkproof.simulation.metrics import STATE_NAMES
from parkproof.simulation.outcome import Outcome
from parkproof.simulation.stress import stress_truths

Floats = NDArray[np.float64]


def bounds_of(certificate: dict[str, Any]) -> Bounds:
    """What the controller may know, from a certificate's assumptions.

    Parameters
    ----------
    certificate : dict
        The certificate.

    Returns
    -------
    Bounds
        Its bounds of α, γ, φ and b2.
    """
    given = certificate["assumptions"]
    one, two = given["disturbance"]
    alpha, gamma = ([(low, high) for low, high in given[name]] for name in ("alpha", "gamma"))
    low, high = given["b2"]
    return Bounds(
        alpha=(alpha[0], alpha[1]),
        gamma=(gamma[0], gamma[1]),
        disturbance=(one, two),
        b2=(low, high),
    )


def gains_of(certificate: dict[str, Any]) -> Gains:
    """The gains that a certificate speaks of.

    Parameters
    ----------
    certificate : dict
        The certificate.

    Returns
    -------
    Gains
        Its gains.
    """
    law = certificate["law"]
    return Gains(**{name: law[name] for name in Gains.__struct_fields__ if name in law})


def switching_of(certificate: dict[str, Any]) -> Switching:
    """When the law of a certificate switches.

    Parameters
    ----------
    certificate : dict
        The certificate.

    Returns
    -------
    Switching
        Its switching.
    """
    law = certificate["law"]
    return Switching(**{name: law[name] for name in Switching.__struct_fields__ if name in law})


def start_at(place: dict[str, float]) -> Start:
    """A start of a certificate's box.

    Parameters
    ----------
    place : dict
        Values of x0, x1, x2, u0 and u1, or of x, y, theta, v and omega.

    Returns
    -------
    Start
        For a scenario.

    Examples
    --------
    >>> start_at({"x": 1.0, "y": 0.5, "theta": 3.0, "v": 0.0, "omega": 0.0}).pose
    (1.0, 0.5, 3.0)
    """
    one, two, three, four, five = place.values()
    if "x0" in place:
        return Start(state=(one, two, three, four, five))
    return Start(pose=(one, two, three), velocity=(four, five))


def stressed_runs(
    certificate: dict[str, Any],
    *,
    count: int,
    seed: int,
    control_period: float,
    noise: float = 0.0,
    latency: float = 0.0,
    extra: float = 3.0,
) -> list[Scenario]:
    """Scenarios from random starts of a certificate's box, under truths that strain the law.

    Parameters
    ----------
    certificate : dict
        The certificate.
    count : int
        How many.
    seed : int
        Trial i depends on the seed and i only.
    control_period : float
        In s.
    noise : float
        Standard deviation of the measured states.
    latency : float
        Delay of the measurements in s.
    extra : float
        How long runs go on after the proven time, in s.

    Returns
    -------
    list of Scenario
        Half of the starts lie at corners of the box.
    """
    bounds = bounds_of(certificate)
    gains, switching = gains_of(certificate), switching_of(certificate)
    duration = math.ceil(certificate["claim"]["total_time"] + extra)
    box = certificate["assumptions"]["starts"]
    scenarios = []
    for i, truth in enumerate(stress_truths(bounds, count=count, seed=seed)):
        draw = random.Random(f"start {seed}:{i}")
        corner = draw.random() < 0.5
        place = {
            name: draw.choice(ends) if corner else draw.uniform(*ends) for name, ends in box.items()
        }
        run = RunSettings(
            duration=duration,
            control_period=control_period,
            discretisation="implicit",
            noise=noise,
            latency=latency,
            seed=draw.getrandbits(31),
        )
        scenarios.append(
            Scenario(
                law=certificate["law"]["name"],
                bounds=bounds,
                gains=gains,
                switching=switching,
                truth=truth,
                start=start_at(place),
                run=run,
            )
        )
    return scenarios


def measured_of(
    certificate: dict[str, Any],
    *,
    control_period: float,
    noise: float = 0.0,
    latency: float = 0.0,
    count: int = 256,
    threads: int = 2,
) -> dict[str, Any]:
    """Measure the residual band, for a certificate's section "measured".

    Parameters
    ----------
    certificate : dict
        The certificate.
    control_period : float
        In s.
    noise : float
        Standard deviation of the measured states.
    latency : float
        Delay of the measurements in s.
    count : int
        Runs.
    threads : int
        For the runs.

    Returns
    -------
    dict
        How it was measured, how many runs parked, and the worst of them.
    """
    trials = stressed_runs(
        certificate,
        count=count,
        seed=0,
        control_period=control_period,
        noise=noise,
        latency=latency,
    )
    rows = simulate_ensemble(trials, threads=threads)
    parked = rows["outcome"] == Outcome.PARKED
    return {
        "control_period": control_period,
        "noise": noise,
        "latency": trials[0].run.delay,
        "form": "implicit",
        "runs": count,
        "parked": int(parked.sum()),
        "slowest": _worst(rows["total"]),
        "residual": _worst(rows["residual"]),
        "peak_tau": [_worst(rows["peak_tau1"]), _worst(rows["peak_tau2"])],
    }


@dataclass(frozen=True)
class Compared:
    """A proven number beside the worst of the runs.

    Attributes
    ----------
    name : str
        Its name in the claim, with the state or the channel.
    proven : float
        The claim.
    worst : float
        The largest of the runs; infinite for a time if a run did not park.

    Examples
    --------
    >>> Compared("max_speed", 2.0, 1.5).ratio
    0.75
    """

    name: str
    proven: float
    worst: float

    @property
    def within(self) -> bool:
        """Whether no run exceeded what is proven."""
        return self.worst <= self.proven

    @property
    def ratio(self) -> float:
        """Worst over proven; NaN where 0 is proven."""
        return self.worst / self.proven if self.proven > 0.0 else math.nan


@dataclass(frozen=True)
class Proven:
    """A proven number, and where its measured counterpart stands.

    Attributes
    ----------
    name : str
        Its name in the claim, with the state or the channel.
    bound : float
        The claim.
    column : str
        The metric of `simulate_ensemble`.
    sign : float
        -1 where the bound is on the metric's negative, 0 where it is on its magnitude.

    Examples
    --------
    >>> Proven("x1_at_rest", 0.01, "x1", sign=0.0).sizes(np.array([-0.5, 0.2]))
    array([0.5, 0.2])
    """

    name: str
    bound: float
    column: str
    sign: float = 1.0

    def sizes(self, values: Floats) -> Floats:
        """What must not exceed the bound."""
        return self.sign * values if self.sign else np.abs(values)


def proven_numbers(claim: Mapping[str, Any]) -> list[Proven]:
    """Every number of a claim, in its order; the range of x0 downwards and upwards.

    Parameters
    ----------
    claim : mapping
        A certificate's section "claim".

    Returns
    -------
    list of Proven
        The total time is the first.
    """
    low, high = claim["x0_range"]
    taus, states = claim["max_tau"], claim["max_abs_state"]
    return [
        Proven("total_time", claim["total_time"], "total"),
        *(Proven(f"max_tau {i}", taus[i - 1], f"peak_tau{i}") for i in (1, 2)),
        *(
            Proven(f"max_abs_state {name}", bound, f"max_{name}")
            for name, bound in zip(STATE_NAMES, states, strict=True)
        ),
        *(
            Proven(name, claim[name], name)
            for name in ("max_speed", "max_turn_rate", "max_heading")
        ),
        Proven("x0_range -", -low, "least_x0", sign=-1.0),
        Proven("x0_range +", high, "largest_x0"),
        Proven("x1_at_rest", claim["x1_at_rest"], "x1", sign=0.0),
    ]


def compare(certificate: dict[str, Any], rows: Mapping[str, Any]) -> list[Compared]:
    """Compare every number of a claim with the worst of an ensemble of runs.

    Parameters
    ----------
    certificate : dict
        The certificate.
    rows : mapping
        From `simulate_ensemble` of `stressed_runs`.

    Returns
    -------
    list of Compared
        In the order of the claim. The range of x0 is compared downwards and upwards.

    Examples
    --------
    See ``benchmarks/stress.py``.
    """
    time, *others = proven_numbers(certificate["claim"])
    parked = all(outcome is Outcome.PARKED for outcome in rows["outcome"])
    slowest = float(np.max(rows["total"])) if parked else math.inf
    return [
        Compared(time.name, time.bound, slowest),
        *(
            Compared(one.name, one.bound, float(np.max(one.sizes(rows[one.column]))))
            for one in others
        ),
    ]


def sampling_bands(certificate: dict[str, Any], control_period: float) -> tuple[float, float]:
    """How far sampling lets u0 and u1 stray from where the law in continuous time holds them.

    Parameters
    ----------
    certificate : dict
        The certificate.
    control_period : float
        In s.

    Returns
    -------
    two floats
        What a disturbance, unopposed for a period, does under the largest gain.

    Examples
    --------
    >>> given = {"alpha": [[1, 1], [1, 1]], "gamma": [[1, 2], [1, 1]],
    ...          "disturbance": [2.5, 0], "b2": [1, 1]}
    >>> sampling_bands({"assumptions": given}, 0.001)
    (0.005, 0.0)
    """
    known = bounds_of(certificate)
    one, two = (
        control_period * known.gamma_of(i)[1] / known.gamma_of(i)[0] * known.disturbance_of(i)
        for i in range(2)
    )
    return one, two


def _worst(values: Floats) -> float | None:
    known = values[np.isfinite(values)]
    return float(f"{known.max():.4g}") if known.size else None
