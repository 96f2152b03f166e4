"""Conditions on Step 2 of the homogeneous law as a table for people and as data for programs."""

from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

if TYPE_CHECKING:
    from parkproof.proof.homogeneous_conditions import HomogeneousConditions


def homogeneous_table(found: "HomogeneousConditions") -> Table:
    """Lay out the conditions.

    Parameters
    ----------
    found : HomogeneousConditions
        Judged.

    Returns
    -------
    rich.table.Table
        A row a condition, and one for the largest input.

    Examples
    --------
    >>> from parkproof.proof.homogeneous_conditions import HomogeneousConditions
    >>> one = (1.0, 1.0)
    >>> homogeneous_table(HomogeneousConditions(one, one, one, 3.0, None, None, 2.0)).row_count
    3
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("condition", no_wrap=True)
    table.add_column("value", overflow="fold")
    table.add_column("", no_wrap=True)
    table.add_row("matrix inequality", _rate(found), _word(holds=found.rate is not None))
    table.add_row("largest |tau2|", f"{found.largest_tau:.5g}, at every state", "")
    strongest = found.gamma[0] * found.largest_tau
    sign = ">" if found.dominated else "<="
    table.add_row(
        "phi dominated",
        f"gamma2_min * largest |tau2| = {strongest:.5g} {sign} {found.disturbance:g}",
        _word(holds=found.dominated),
    )
    return table


def _rate(found: "HomogeneousConditions") -> str:
    if found.rate is None:
        return "no rate at which V falls was proved"
    return f"V falls at least at the rate beta = {found.rate:.4g}, to 0 within V(start)/beta"


def _word(*, holds: bool) -> str:
    return "holds" if holds else "fails"


def homogeneous_facts(found: "HomogeneousConditions") -> str:
    """The bounds that the conditions are judged for.

    Parameters
    ----------
    found : HomogeneousConditions
        Judged.

    Returns
    -------
    str
        One line.

    Examples
    --------
    >>> from parkproof.proof.homogeneous_conditions import HomogeneousConditions
    >>> one = (1.0, 1.0)
    >>> homogeneous_facts(HomogeneousConditions(one, one, one, 3.0, None, None, 2.0))
    'b1 = alpha2 |u0| in [1, 1], b2 in [1, 1], gamma2 in [1, 1], |phi2| <= 3'
    """
    ranges = (
        f"{name} in [{low:.5g}, {high:.5g}]"
        for name, (low, high) in (
            ("b1 = alpha2 |u0|", found.b1),
            ("b2", found.b2),
            ("gamma2", found.gamma),
        )
    )
    return f"{', '.join(ranges)}, |phi2| <= {found.disturbance:g}"


def homogeneous_verdict(found: "HomogeneousConditions") -> str:
    """One sentence on Step 2.

    Parameters
    ----------
    found : HomogeneousConditions
        Judged.

    Returns
    -------
    str
        Like those on the paper's conditions.

    Examples
    --------
    >>> from parkproof.proof.homogeneous_conditions import HomogeneousConditions
    >>> one = (1.0, 1.0)
    >>> homogeneous_verdict(HomogeneousConditions(one, one, one, 3.0, None, None, 2.0))
    'Step 2: not satisfied; these fail: matrix inequality, phi dominated.'
    """
    if found.holds:
        return "Step 2: satisfied by the matrix inequality."
    failing = ["matrix inequality"] if found.rate is None else []
    failing += [] if found.dominated else ["phi dominated"]
    return f"Step 2: not satisfied; these fail: {', '.join(failing)}."


def homogeneous_data(found: "HomogeneousConditions") -> dict[str, Any]:
    """Give the conditions as plain data.

    Parameters
    ----------
    found : HomogeneousConditions
        Judged.

    Returns
    -------
    dict
        The matrix inequality, the largest input, and whether it dominates the disturbance.

    Examples
    --------
    >>> from parkproof.proof.homogeneous_conditions import HomogeneousConditions
    >>> one = (1.0, 1.0)
    >>> data = homogeneous_data(HomogeneousConditions(one, one, one, 3.0, None, None, 2.0))
    >>> data["largest_tau2"], data["disturbance_dominated"]["holds"]
    (2.0, False)
    """
    return {
        "matrix_inequality": {
            "b1": list(found.b1),
            "b2": list(found.b2),
            "gamma": list(found.gamma),
            "disturbance": found.disturbance,
            "rate": found.rate,
            "rho": None if found.rho is None else list(found.rho),
            "holds": found.rate is not None,
        },
        "largest_tau2": found.largest_tau,
        "disturbance_dominated": {
            "strongest": found.gamma[0] * found.largest_tau,
            "disturbance": found.disturbance,
            "holds": found.dominated,
        },
    }
