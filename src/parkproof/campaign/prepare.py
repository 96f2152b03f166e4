"""A campaign made ready to run: checked at the ends of its distributions, trials as scenarios."""

import itertools
import json
import math
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from parkproof.campaign.definition import Campaign, Quantity, campaign_from_dict
from parkproof.campaign.distributions import Choice, Constant, Continuous
from parkproof.campaign.draw import WHOLE, settings_of
from parkproof.campaign.lanes import can_differ
from parkproof.errors import InputError
from parkproof.model.unicycle import headings_to_check
from parkproof.scenario import Scenario
from parkproof.scenario_file import resolved, scenario_from_dict
from parkproof.scenario_file.keys import Place
from parkproof.scenario_file.overrides import put
from parkproof.scenario_file.words import plain

MOST_GROUPS = 100
"""Most combinations of choices that split the trials: each becomes an ensemble of its own."""

Settings = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Prepared:
    """A campaign, and which of its quantities may differ side by side.

    Attributes
    ----------
    campaign : Campaign
        The campaign.
    base : dict
        Its scenario as plain tables, with the constants of its distributions.
    side_by_side : tuple of Quantity
        Numbers that differ between the lanes of one ensemble.
    splitting : tuple of Quantity
        Choices that trials of one ensemble share.
    where : str
        What a message calls the campaign.

    Examples
    --------
    See `prepare`.
    """

    campaign: Campaign
    base: dict[str, Any]
    side_by_side: tuple[Quantity, ...]
    splitting: tuple[Quantity, ...]
    where: str
    _groups: dict[int, Scenario] = field(default_factory=dict, repr=False)

    def scenario_of(self, trial: int) -> Scenario:
        """Give one trial as a scenario of its own.

        Parameters
        ----------
        trial : int
            Number of the trial, from 0.

        Returns
        -------
        Scenario
            That repeats it, by `parkproof.simulate` or in a file for ``parkproof park``.

        Examples
        --------
        See `prepare`.
        """
        settings = settings_of(self.campaign, trial)
        title = self.campaign.scenario.title
        settings["title"] = f"{title}, trial {trial}" if title else f"Trial {trial}"
        where = f"{self.where}: trial {trial}"
        scenario = self._with(settings, where)
        if any(scenario.run.deviations) and all(q.key != "run.seed" for q in self.side_by_side):
            settings["run.seed"] = scenario.run.seed + trial  # noise of its own
            return self._with(settings, where)
        return scenario

    def group(self, index: int) -> Scenario:
        """Give what the trials of one combination of choices share.

        Parameters
        ----------
        index : int
            Number of the combination; the last choice changes fastest.

        Returns
        -------
        Scenario
            What is drawn side by side has its lowest value.

        Examples
        --------
        See `prepare`.
        """
        if index not in self._groups:
            settings = {q.key: probes_of(q)[0] for q in self.side_by_side}
            chosen = self._choices(index)
            self._groups[index] = self._with(settings | chosen, self._at(chosen))
        return self._groups[index]

    def numbers_of(self, drawn: Mapping[str, NDArray[Any]]) -> dict[Place, NDArray[Any]]:
        """Give what differs side by side as numbers.

        Parameters
        ----------
        drawn : mapping of str to array
            From `parkproof.campaign.draw.drawn_values`.

        Returns
        -------
        dict of tuple to array
            By place.

        Examples
        --------
        See `parkproof.campaign.rows.rows_of`.
        """
        found: dict[Place, NDArray[Any]] = {}
        for quantity in self.side_by_side:
            values, given = values_of(quantity), drawn[quantity.key]
            found[quantity.place] = np.array(values, dtype=float)[given] if values else given
        return found

    @property
    def groups(self) -> int:
        """Number of combinations of choices."""
        return math.prod(len(values_of(quantity)) for quantity in self.splitting)

    def _choices(self, index: int) -> dict[str, Any]:
        """The choices of one combination."""
        sizes = [len(values_of(quantity)) for quantity in self.splitting]
        places = np.unravel_index(index, sizes) if sizes else ()
        return {q.key: values_of(q)[int(i)] for q, i in zip(self.splitting, places, strict=True)}

    def _at(self, settings: Settings) -> str:
        """What a message calls the campaign with some of its values."""
        said = ", ".join(f"{key} = {plain(str(value))}" for key, value in settings.items())
        return f"{self.where}: [distributions] {f'at {said}' if said else ''}".rstrip()

    def _with(self, settings: Settings, where: str) -> Scenario:
        """The scenario with some of its keys set."""
        data = deepcopy(self.base)
        keys = {quantity.key: quantity.place for quantity in self.campaign.quantities}
        for key, value in settings.items():
            put(data, keys.get(key) or tuple(key.split(".")), value, f"{where}: {key}")
        return scenario_from_dict(data, where=where)

    def check(self) -> None:
        """Check the scenarios at the ends of all distributions, for each combination of choices.

        Rules hold between the keys of one signal or of the start, so that the ends of those are
        combined with one another.

        Raises
        ------
        InputError
            If one is no valid scenario, or lanes cannot carry it out.

        Examples
        --------
        See `prepare`.
        """
        if self.groups > MOST_GROUPS:
            raise InputError(
                f"{self.where}: [distributions] the choices of "
                f"{', '.join(q.key for q in self.splitting)} have {self.groups:,} combinations, "
                f"and each is an ensemble of its own: at most {MOST_GROUPS}; write fewer values"
            )
        lowest = {q.key: probes_of(q)[0] for q in self.side_by_side}
        for index in range(self.groups):
            chosen = self._choices(index)
            for corner in self._corners():
                where = self._at(chosen | corner)
                scenario = self._with(lowest | chosen | corner, where)
                self._check_engine(scenario, where)

    def _check_engine(self, scenario: Scenario, where: str) -> None:
        for quantity in self.side_by_side:
            if not can_differ(scenario, quantity.place):
                raise InputError(
                    f'{where}: "{quantity.key}" is no number that trials side by side can differ '
                    'in; write it as { kind = "choice", values = [...] }'
                )

    def _corners(self) -> Iterator[dict[str, Any]]:
        """Ends of the quantities of the start, and of each signal, in all combinations."""
        units: dict[Place, list[Quantity]] = {}
        for quantity in self.side_by_side:
            units.setdefault(_unit(quantity.place), []).append(quantity)
        yield {}
        for members in units.values():
            for values in itertools.product(*(probes_of(q) for q in members)):
                yield {q.key: value for q, value in zip(members, values, strict=True)}


def _unit(place: Place) -> Place:
    """What a rule of a scenario holds for as a whole: the start, or one signal."""
    if place[0] != "truth":
        return place[:1]
    return place[:-1] if len(place) > 2 and isinstance(place[-1], str) else place


def values_of(quantity: Quantity) -> tuple[Any, ...]:
    """Give the values of a choice.

    Parameters
    ----------
    quantity : Quantity
        Any.

    Returns
    -------
    tuple
        None for other distributions.

    Examples
    --------
    >>> values_of(Quantity(key="run.latency", place=("run", "latency"),
    ...                    distribution=Choice(values=(0.0, 0.03))))
    (0.0, 0.03)
    """
    return quantity.distribution.values if isinstance(quantity.distribution, Choice) else ()


def probes_of(quantity: Quantity) -> tuple[Any, ...]:
    """Values at which a quantity is checked.

    Parameters
    ----------
    quantity : Quantity
        A number.

    Returns
    -------
    tuple
        The ends; for a heading, which a law may not take near 90°, also what is between.

    Examples
    --------
    >>> from parkproof.campaign.distributions import Uniform
    >>> probes_of(Quantity(key="start.pose[2]", place=("start", "pose", 2),
    ...                    distribution=Uniform(low=-2.0, high=1.5)))
    (-2.0, 1.5, -1.0, 0.0, 1.0)
    """
    distribution = quantity.distribution
    if isinstance(distribution, Constant):
        return (distribution.value,)
    if isinstance(distribution, Choice):
        return min(distribution.values), max(distribution.values)
    low, high = distribution.ends
    if quantity.place[-1] in WHOLE:
        return math.ceil(low), math.floor(high)
    if quantity.place == ("start", "pose", 2):
        return headings_to_check(low, high)
    return low, high


def prepare(campaign: Campaign, *, where: str, check: bool = True) -> Prepared:
    """Make a campaign ready to run.

    Parameters
    ----------
    campaign : Campaign
        The campaign.
    where : str
        What a message calls it: its file's name.
    check : bool
        Whether to check what it draws; it was once where it comes from its own directory.

    Returns
    -------
    Prepared
        Ready.

    Raises
    ------
    InputError
        If it can draw what is no valid scenario, or what lanes cannot carry out, or nothing
        differs between its trials.

    Examples
    --------
    >>> campaign = campaign_from_dict(
    ...     {"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10, "seed": 1,
    ...      "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}},
    ...     where="example")
    >>> scenario = prepare(campaign, where="example").scenario_of(3)
    >>> scenario.title, -2.0 <= scenario.start.pose[0] <= -1.0
    ('Trial 3', True)
    """
    base = resolved(campaign.scenario)
    for quantity in campaign.quantities:
        name = f'{where}: [distributions] "{quantity.key}"'
        value = (
            quantity.distribution.value
            if isinstance(quantity.distribution, Constant)
            else probes_of(quantity)[0] if quantity.numeric else values_of(quantity)[0]
        )  # fmt: skip
        if quantity.place[-1] in WHOLE:
            _check_whole(quantity, name)
        put(base, quantity.place, value, name)
    one = scenario_from_dict(base, where=f"{where}: [distributions] at their lowest values")
    drawn = [quantity for quantity in campaign.quantities if quantity.drawn]
    side = tuple(q for q in drawn if q.numeric and can_differ(one, q.place))
    splitting = tuple(q for q in drawn if q not in side)
    for quantity in splitting:
        if isinstance(quantity.distribution, Continuous):
            ends = ", ".join(f"{end:g}" for end in quantity.distribution.ends)
            raise InputError(
                f'{where}: [distributions] "{quantity.key}": trials side by side share this key, '
                'so that it can only be a choice; write for example { kind = "choice", values = '
                f"[{ends}] }}"
            )
    if not drawn and not any(one.run.deviations):
        raise InputError(
            f"{where}: [distributions] draws nothing, so that all trials would be the same; write "
            'a line such as "start.pose[0]" = { kind = "uniform", low = -2.0, high = -1.0 }'
        )
    ready = Prepared(
        campaign=campaign, base=base, side_by_side=side, splitting=splitting, where=where
    )
    if check:
        ready.check()
    return ready


def _check_whole(quantity: Quantity, name: str) -> None:
    """Check that a seed is drawn from whole numbers."""
    distribution = quantity.distribution
    if isinstance(distribution, Constant):
        given: tuple[Any, ...] = (distribution.value,)
    elif isinstance(distribution, Choice):
        given = distribution.values
    else:
        given = distribution.ends
        if distribution.__struct_config__.tag != "uniform":
            raise InputError(f'{name}: a seed is a whole number; write kind = "uniform"')
    if any(isinstance(v, bool) or not isinstance(v, int | float) or v % 1.0 for v in given):
        raise InputError(f"{name}: a seed is a whole number; write whole numbers")


@lru_cache(maxsize=4)
def prepared_from(text: str) -> Prepared:
    """Make a campaign ready that comes as text, once a process.

    Parameters
    ----------
    text : str
        JSON of `parkproof.campaign.definition.plain_of`, checked before.

    Returns
    -------
    Prepared
        Ready.

    Examples
    --------
    >>> text = '''{"law": "corrected", "start": {"pose": [-1, 0, 0]}, "trials": 10,
    ...     "distributions": {"start.pose[0]": {"kind": "uniform", "low": -2, "high": -1}}}'''
    >>> prepared_from(text).groups
    1
    """
    campaign = campaign_from_dict(json.loads(text), where="campaign")
    return prepare(campaign, where="campaign", check=False)
