"""What a campaign is: a scenario, what differs between trials, how many of them, and a seed.

A campaign file is a scenario file with ``trials``, ``seed``, ``draws``, ``precision`` and a table
of distributions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast

import msgspec

from parkproof.campaign.distributions import Choice, Constant, Distribution
from parkproof.errors import InputError
from parkproof.scenario import Scenario
from parkproof.scenario_file import resolved
from parkproof.scenario_file.errors import sentence
from parkproof.scenario_file.keys import Place, parse_place
from parkproof.scenario_file.overrides import apply_overrides, check_known
from parkproof.scenario_file.read import converted, named_with
from parkproof.scenario_file.toml import load_toml
from parkproof.simulation.trials import Precision

Draws = Literal["sobol", "independent"]

MOST_SOBOL = 2**30
"""Points of a Sobol sequence of 30 bits, after which it would begin again."""

MOST = 10**15
"""Most trials of any campaign: their numbers stay whole as floats."""

OWN_KEYS = ("trials", "seed", "draws", "precision", "distributions")
"""Keys of a campaign file that no scenario has."""


class CampaignFile(Scenario, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A campaign file: all keys of a scenario, and these.

    Parameters
    ----------
    trials : int
        How many trials.
    seed : int
        What is drawn depends on it, on the number of the trial and on the file, on nothing else.
    draws : "sobol" or "independent"
        A scrambled Sobol sequence, which fills the space evenly, or independent draws.
    precision : "double" or "single"
        Of the trials; single is for statistics only.
    distributions : dict
        A distribution for each key of the scenario that differs from trial to trial.

    Raises
    ------
    InputError
        If the scenario, the number of trials or the seed breaks a rule.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> CampaignFile(law="corrected", start=Start(pose=(-1.0, 0.0, 0.0)), trials=100).draws
    'sobol'
    """

    trials: int
    seed: int = 0
    draws: Draws = "sobol"
    precision: Precision = "double"
    distributions: dict[str, Any] = msgspec.field(default_factory=dict)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_trials(self.trials, self.draws)
        if not 0 <= self.seed < 2**63:
            raise InputError(f"seed = {self.seed}: must be from 0 to {2**63 - 1}; write seed = 0")


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """What differs between trials: a key of the scenario and its distribution.

    Attributes
    ----------
    key : str
        As in the file, such as ``truth.alpha[0]``.
    place : tuple
        The key's parts.
    distribution : Distribution
        Of its values.

    Examples
    --------
    >>> Quantity(key="truth.b2", place=("truth", "b2"), distribution=Constant(value=1.0)).drawn
    False
    """

    key: str
    place: Place
    distribution: Distribution

    @property
    def drawn(self) -> bool:
        """Whether a number is drawn for it."""
        return not isinstance(self.distribution, Constant)

    @property
    def numeric(self) -> bool:
        """Whether its values are numbers."""
        if isinstance(self.distribution, Choice):
            return all(_is_number(value) for value in self.distribution.values)
        return not isinstance(self.distribution, Constant) or _is_number(self.distribution.value)


@dataclass(frozen=True, kw_only=True)
class Campaign:
    """A campaign, read and checked key by key; `parkproof.campaign.prepare` checks what it draws.

    Attributes
    ----------
    scenario : Scenario
        What its file says, before anything is drawn.
    quantities : tuple of Quantity
        What differs, in the order of the keys' names: the order in the file does not matter.
    trials : int
        How many trials.
    seed : int
        Seed of the draws.
    draws : "sobol" or "independent"
        How they are drawn.
    precision : "double" or "single"
        How precisely trials are carried out.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.0, 0.0)))
    >>> campaign = Campaign(scenario=scenario, quantities=(), trials=8, seed=0, draws="sobol")
    >>> plain_of(campaign)["trials"]
    8
    """

    scenario: Scenario
    quantities: tuple[Quantity, ...]
    trials: int
    seed: int
    draws: Draws
    precision: Precision = "double"


def check_trials(trials: int, draws: Draws) -> None:
    """Check how many trials are asked for.

    Parameters
    ----------
    trials : int
        How many.
    draws : "sobol" or "independent"
        How they are drawn.

    Raises
    ------
    InputError
        If there are none, or more than can be drawn.

    Examples
    --------
    >>> check_trials(0, "sobol")
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: trials = 0: a campaign needs at least 1; write for example ...
    """
    if trials < 1:
        raise InputError(
            f"trials = {trials}: a campaign needs at least 1; write for example trials = 10000"
        )
    if draws == "sobol" and trials > MOST_SOBOL:
        raise InputError(
            f"trials = {trials}: a Sobol sequence has {MOST_SOBOL:,} points before it begins "
            'again; write fewer, or draws = "independent"'
        )
    if trials > MOST:
        raise InputError(f"trials = {trials}: at most {MOST:,}; write fewer")


def read_campaign(path: Path, *, overrides: Sequence[str] = ()) -> Campaign:
    r"""Read a campaign file.

    Parameters
    ----------
    path : Path
        A TOML file; `parkproof init --kind campaign` writes one with every key explained.
    overrides : sequence of str
        Expressions ``key=value`` as for a scenario, such as ``run.duration=10`` or ``trials=100``.

    Returns
    -------
    Campaign
        Its keys and values are checked.

    Raises
    ------
    InputError
        If the file cannot be read, is not TOML, or is no campaign.

    Examples
    --------
    >>> import tempfile
    >>> from parkproof.scenario_file import template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "campaign.toml"
    ...     _ = path.write_text(template("campaign"))
    ...     read_campaign(path, overrides=["trials=64"]).trials
    64
    """
    data = load_toml(Path(path), kind="campaign")
    apply_overrides(data, overrides, CampaignFile)
    return campaign_from_dict(data, where=named_with(path, overrides))


def campaign_from_dict(data: Mapping[str, Any], *, where: str) -> Campaign:
    """Make a campaign of plain tables, lists, numbers and strings.

    Parameters
    ----------
    data : mapping
        Keys as in a campaign file.
    where : str
        What a message calls the data: the file's name.

    Returns
    -------
    Campaign
        Its keys and values are checked.

    Raises
    ------
    InputError
        If it is no campaign.

    Examples
    --------
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> campaign.quantities[0].distribution.ends
    (-2.0, -1.0)
    """
    if "trials" not in data and "law" in data:
        raise InputError(
            f"{where}: trials is missing, so this is no campaign; write for example trials = 10000 "
            "and a [distributions] table, as in: parkproof init --kind campaign"
        )
    file = converted(data, CampaignFile, where)
    scenario = Scenario(**{name: getattr(file, name) for name in Scenario.__struct_fields__})
    quantities = tuple(
        _quantity(key, table, where) for key, table in sorted(file.distributions.items())
    )
    places = [quantity.place for quantity in quantities]
    for inner in places:
        for outer in places:
            if len(outer) < len(inner) and inner[: len(outer)] == outer:
                raise InputError(
                    f"{where}: [distributions] draws {_key(outer, quantities)} and "
                    f"{_key(inner, quantities)}, which is a part of it; leave one of them out"
                )
    if len(set(places)) < len(places):
        raise InputError(f"{where}: [distributions] draws one key twice; leave one of them out")
    return Campaign(
        scenario=scenario,
        quantities=quantities,
        trials=file.trials,
        seed=file.seed,
        draws=file.draws,
        precision=file.precision,
    )


def _key(place: Place, quantities: Sequence[Quantity]) -> str:
    """The key of a place as the file has it."""
    return next(quantity.key for quantity in quantities if quantity.place == place)


def _quantity(key: str, table: object, where: str) -> Quantity:
    """Check one line of the table of distributions."""
    place, name = parse_place(key), f'{where}: [distributions] "{key}"'
    if not place:
        raise InputError(
            f'{name}: is no key; write a key of the scenario in quotes, such as "start.pose[0]"'
        )
    if place[0] in OWN_KEYS:
        raise InputError(f"{name}: the key is the campaign's own; write one of the scenario")
    check_known(place, Scenario, name)
    try:
        distribution = msgspec.convert(table, Distribution)
    except msgspec.ValidationError as error:
        said = sentence(error, table, cast(type, Distribution))
        raise InputError(f"{name}: {said}") from error
    return Quantity(key=key, place=place, distribution=cast(Distribution, distribution))


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def plain_of(campaign: Campaign) -> dict[str, Any]:
    """Give a campaign as plain tables: what repeats it.

    Parameters
    ----------
    campaign : Campaign
        Any.

    Returns
    -------
    dict
        Dicts, lists, numbers, strings and booleans only, every default filled in;
        `campaign_from_dict` makes an equal campaign of it.

    Examples
    --------
    >>> from parkproof.scenario import Start
    >>> scenario = Scenario(law="corrected", start=Start(pose=(-1.0, 0.0, 0.0)))
    >>> campaign = Campaign(scenario=scenario, quantities=(), trials=8, seed=3, draws="sobol")
    >>> campaign_from_dict(plain_of(campaign), where="example") == campaign
    True
    """
    return {
        "trials": campaign.trials,
        "seed": campaign.seed,
        "draws": campaign.draws,
        "precision": campaign.precision,
        **resolved(campaign.scenario),
        "distributions": {
            quantity.key: msgspec.to_builtins(quantity.distribution)
            for quantity in campaign.quantities
        },
    }
