"""Limits of a specification: what no gains can keep, what a candidate exceeds, what would do."""

from collections.abc import Sequence

from parkproof.errors import InputError
from parkproof.proof.candidates import Candidate
from parkproof.spec import Spec


def check_feasible(spec: Spec) -> None:
    """Refuse what no gains can do.

    Parameters
    ----------
    spec : Spec
        What is wanted.

    Raises
    ------
    InputError
        If an input does not dominate its disturbance, or a start or the goal lies outside the
        view, or a start moves faster than allowed.

    Examples
    --------
    >>> from parkproof.bounds import Bounds, Limits
    >>> known = Bounds(gamma=(0.5, 1.0), disturbance=3.0)
    >>> check_feasible(Spec(bounds=known, limits=Limits(tau=(5.0, 5.0))))
    Traceback (most recent call last):
    ...
    parkproof.errors.InputError: limits.tau[0] = 5: ... above 6
    """
    limits, bounds, ranges = spec.limits, spec.bounds, spec.starts.ranges
    if limits.tau is not None:
        for i, tau in enumerate(limits.tau):
            needed = bounds.disturbance_of(i) / bounds.gamma_of(i)[0]
            if needed >= tau:
                raise InputError(
                    f"limits.tau[{i}] = {tau:g}: the weakest motor gain times it does not exceed "
                    f"the disturbance {bounds.disturbance_of(i):g}; write one above {needed:g}"
                )
    x, y = (ranges.get(a) or ranges[b] for a, b in (("x", "x0"), ("y", "x1")))
    if limits.view is not None:
        low, high, below, above = limits.view
        if x[0] < low or x[1] > high or y[0] < below or y[1] > above:
            raise InputError(
                f"limits.view = {list(limits.view)}: starts reach from ({x[0]:g}, {y[0]:g}) to "
                f"({x[1]:g}, {y[1]:g}); widen the view or narrow [starts]"
            )
        if max(low, below) > 0.0 or min(high, above) < 0.0:
            raise InputError(
                f"limits.view = {list(limits.view)}: the goal (0, 0), where the robot parks, lies "
                "outside; widen the view"
            )
    forward = max(abs(end) for end in ranges.get("u0") or ranges["v"])
    turning = max(abs(end) for end in ranges.get("u1") or ranges["omega"])
    for name, start in (("speed", forward), ("turn_rate", turning)):
        limit = getattr(limits, name)
        if limit is not None and start >= limit:
            raise InputError(
                f"limits.{name} = {limit:g}: starts already reach {start:g}; raise it, or narrow "
                "[starts]"
            )


def over_limits(candidate: Candidate, spec: Spec) -> list[str]:
    """Names of the limits that a candidate's bounds exceed.

    Parameters
    ----------
    candidate : Candidate
        Gains with bounds.
    spec : Spec
        Limits.

    Returns
    -------
    list of str
        As in the specification, such as "limits.tau[0]".
    """
    pairs = candidate.excesses(spec)
    return [name for name, (needed, allowed) in pairs.items() if needed > allowed]


def nearest(spec: Spec, looked_at: Sequence[Candidate], best: Candidate) -> str:
    """Say which limit binds, and the nearest value with which all can be kept.

    Parameters
    ----------
    spec : Spec
        Limits.
    looked_at : sequence of Candidate
        None of them keeps all.
    best : Candidate
        The best of them.

    Returns
    -------
    str
        The reason that there is no design.
    """
    found: dict[str, tuple[float, Candidate]] = {}
    for candidate in looked_at:
        names = over_limits(candidate, spec)
        groups = {name.partition("[")[0] for name in names}
        if len(groups) == 1:
            pairs = candidate.excesses(spec)
            excess = max(pairs[name][0] / abs(pairs[name][1] or 1e-9) for name in names)
            group = groups.pop()
            if group not in found or excess < found[group][0]:
                found[group] = (excess, candidate)
    if not found:
        over = " and ".join(over_limits(best, spec))
        return f"no gains were found that keep all limits; the best exceed {over}: relax them all"
    texts = []
    for group, (_, candidate) in sorted(found.items(), key=lambda item: item[1][0]):
        pairs = candidate.excesses(spec)
        needs = " and ".join(_need(name, *pairs[name]) for name in over_limits(candidate, spec))
        texts.append(f"{group} binds, all else as it is: {needs}")
    return "no gains were found that keep all limits; " + "; or ".join(texts)


def _need(name: str, needed: float, allowed: float) -> str:
    """What would do in the place of a limit; the low ends of a view are negative."""
    sign = -1.0 if name in ("limits.view[0]", "limits.view[2]") else 1.0
    return f"{name} = {sign * needed:.4g} would do, {sign * allowed:g} does not"
