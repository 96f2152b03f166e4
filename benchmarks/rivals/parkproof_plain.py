"""Parkproof's plain Python: the reference run, and the same loop by Euler's method."""

from collections.abc import Callable
from typing import Any

import numpy as np
from work import Found, Work

from parkproof import Scenario, simulate
from parkproof.laws.controller import Controller, measured_state
from parkproof.model.chained import ChainedState, chained_rates, extension_rate
from parkproof.model.signals import signal_value
from parkproof.model.truth import channel, scales


def found_of(ends: dict[int, float], columns: dict[str, Any], duration: float) -> Found:
    """What is kept of one trial, from its samples."""
    largest = [np.max(np.abs(columns[n])) for n in ("tau1", "tau2", "x0", "x1", "x2", "u0", "u1")]
    x0, x1, square = columns["x0"], columns["x1"], 1.0 + columns["x2"] ** 2
    taus = [columns[name] for name in ("tau1", "tau2")]
    metrics = [
        *largest,
        np.max(np.hypot(x0, x1)),
        *(np.sqrt(np.mean(tau**2)) for tau in taus),
        *(np.sum(np.abs(np.diff(tau))) / duration for tau in taus),
        np.sum(np.hypot(np.diff(x0), np.diff(x1))),
        np.min(x0),
        np.max(x0),
        np.sqrt(np.max(columns["u0"] ** 2 * square)),
        np.max(np.abs(columns["u1"]) / square),
    ]
    kept = [ends.get(i, -1.0) for i in (1, 2, 3)]
    return Found(np.array([kept]), np.array([metrics]))


def together(trials: list[Found]) -> Found:
    """Trials below each other."""
    ends, metrics = zip(*trials, strict=True)
    return Found(np.vstack(ends), np.vstack(metrics))


def prepare(work: Work) -> Callable[[], Found]:
    """Nothing to prepare."""

    def park(scenario: Scenario) -> Found:
        done = simulate(scenario)
        times = {int(i): t for i, t in done.settling_time.steps.items() if t is not None}
        return found_of(times, done.trajectory, scenario.run.duration)

    return lambda: together([park(scenario) for scenario in work.scenarios])


def by_euler(work: Work) -> Found:
    """Parkproof's own controller and model, with a plant by Euler's method: what rivals must find.

    Not timed.
    """
    return together([_by_euler(scenario) for scenario in work.scenarios])


def _by_euler(scenario: Scenario) -> Found:
    h = scenario.run.control_period
    controller = Controller(
        law=scenario.law,
        bounds=scenario.bounds,
        gains=scenario.gains,
        switching=scenario.switching,
        control_period=h,
    )
    channels = [channel(i, scenario.truth, scenario.bounds) for i in range(2)]
    gains = [mean for mean, _ in scales(scenario.truth, scenario.bounds)]
    state = ChainedState(*(scenario.start.chained or ()))
    samples, ends, last = [], {}, 1
    for k in range(scenario.run.samples):
        t = k * h
        command = controller.step(measured_state(t, state))
        if command.step > last:
            ends[last] = t
        elif command.step < last:
            ends = {i: end for i, end in ends.items() if i < command.step}
        last, tau = command.step, (command.tau1, command.tau2)
        samples.append((*state, *tau))
        last_states = (
            extension_rate(
                command,
                signal_value(one.gamma_mean, one.gamma_tones, t),
                signal_value(one.phi_mean, one.phi_tones, t),
            )
            for one, command in zip(channels, tau, strict=True)
        )
        rates = (*chained_rates(state.x2, state.u0, state.u1, *gains), *last_states)
        state = ChainedState(*(x + h * rate for x, rate in zip(state, rates, strict=True)))
    names = ("x0", "x1", "x2", "u0", "u1", "tau1", "tau2")
    columns = dict(zip(names, np.array(samples).T, strict=True))
    return found_of(ends, columns, scenario.run.duration)
