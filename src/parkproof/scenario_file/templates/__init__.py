"""Files to start from: TOML with every key explained, each of which runs as it is."""

from parkproof.errors import InputError
from parkproof.scenario_file.keys import nearest

TEMPLATES = {
    "paper": "Section 4 of the paper: its start, gains, bounds and published law",
    "corrected": "the same with the corrected law in its implicit, chattering-free form",
    "homogeneous": "the same with an input in Step 2 that is bounded at every state",
    "adversary": "the same start against the worst gains and disturbances that the bounds allow",
    "velocity-robot": "a robot that takes speed and turn rate, steered from a 30 Hz camera",
    "tilted-camera": "the same under a tilted, rolled pinhole camera that nobody calibrated",
    "torque-robot": "a robot that takes accelerations and starts facing away from the goal",
    "noise": "seeded noise and square waves as motor gains and disturbances",
}
"""Kinds of scenario files, each with a line on what it shows."""

SPECIFICATIONS = {
    "design": "no scenario, but what parkproof design is to find gains for",
    "campaign": "a scenario and what differs from trial to trial, for parkproof campaign",
    "world": "no scenario, but the simulated laboratory of parkproof lab",
    "robot": "no scenario, but the robot of a real laboratory: address, limits, wheels",
}
"""Kinds of other files, each with a line on what it is."""


def template(kind: str) -> str:
    """Give a commented file that runs as it is.

    Parameters
    ----------
    kind : str
        One of `TEMPLATES` or `SPECIFICATIONS`.

    Returns
    -------
    str
        TOML.

    Raises
    ------
    InputError
        If there is no such kind.

    Examples
    --------
    >>> print(template("paper").splitlines()[0])
    # The simulation of Section 4 of the paper, with its published law.
    """
    from importlib import resources

    kinds = TEMPLATES | SPECIFICATIONS
    if kind not in kinds:
        near = nearest(kind, kinds)
        meant = f'did you mean "{near}"? ' if near is not None else ""
        raise InputError(f'kind "{kind}": unknown; {meant}the kinds are {", ".join(kinds)}')
    return resources.files(__package__).joinpath(f"{kind}.toml").read_text(encoding="utf-8")
