"""The shape of a certificate: which keys it has, and what kind of value each holds, exactly."""

import re
from typing import Any

Shape = Any
"""0: a number; n: a list of n numbers; (m, n): m lists of n numbers; a pattern: a text that matches
it; a tuple of words: one of them; a dict: just these keys."""

RATIO = re.compile(r"[1-9]\d{0,5}/[1-9]\d{0,5}")
"""An exponent, of a size that exact arithmetic can bear."""

TWO_CHAIN = {"k2": 0, "rate": 0, "sizes": 3}

LAW = {
    "q0": RATIO,
    "q1": RATIO,
    "q2": RATIO,
    "lambda1": 0,
    "k": 2,
    "hold": 2,
    "runup_speed": 0,
    "direction": ("forward", "backward", "toward", "auto"),
    "return_steering": (False,),
    "tolerance": 3,
    "hysteresis": 0,
    "turn_tolerance": 0,
    "chart_limit": 0,
}

BY_LAW: dict[str, tuple[dict[str, Shape], dict[str, Shape]]] = {
    "corrected": ({"l": 3}, {"k": 2, "s": 2, "rate": 0, "sizes": 4}),
    "homogeneous": ({"ellipsoid": 6, "feedback": 3}, {"rate": 0, "rho": 2}),
}
"""What a law adds to LAW, and what the proof of its approach holds."""

STARTS = (("x0", "x1", "x2", "u0", "u1"), ("x", "y", "theta", "v", "omega"))

CLAIM = {
    "total_time": 0,
    "max_tau": 2,
    "max_abs_state": 5,
    "max_speed": 0,
    "max_turn_rate": 0,
    "max_heading": 0,
    "x0_range": 2,
    "x1_at_rest": 0,
}

WORD = re.compile(r"[a-z_0-9]{1,40}")


def _is_simple(shape: Shape) -> bool:
    words = isinstance(shape, tuple) and type(shape[0]) is not int
    return isinstance(shape, re.Pattern) or words or shape == 0


def _fits(value: Any, shape: Shape) -> bool:
    """Whether a single value has its shape; a text is no number, and True is not 1."""
    if isinstance(shape, re.Pattern):
        return type(value) is str and shape.fullmatch(value) is not None
    if isinstance(shape, tuple):
        return any(type(word) is type(value) and value == word for word in shape)
    return type(value) in (int, float)


def misfit(value: Any, shape: Shape, place: str = "") -> str:
    """Where a value does not have its shape.

    Parameters
    ----------
    value : object
        From JSON.
    shape : Shape
        What it must be.
    place : str
        What it is called.

    Returns
    -------
    str
        The place of the first misfit; empty if there is none.

    Examples
    --------
    >>> misfit({"a": [1.0, "2"]}, {"a": 2}), misfit({"a": [1.0, 2]}, {"a": 2})
    ('a[1]', '')
    """
    if isinstance(shape, dict):
        if type(value) is not dict or set(value) != set(shape):
            return place or "its keys"
        inner = (misfit(value[key], shape[key], f"{place}.{key}".lstrip(".")) for key in shape)
        return next(filter(None, inner), "")
    if _is_simple(shape):
        return "" if _fits(value, shape) else place
    count, each = shape if isinstance(shape, tuple) else (shape, 0)
    if type(value) is not list or len(value) != count:
        return place
    inner = (misfit(part, each, f"{place}[{i}]") for i, part in enumerate(value))
    return next(filter(None, inner), "")


def misfit_of_certificate(certificate: dict[str, Any]) -> str:
    """Where a certificate does not have the shape of one.

    Parameters
    ----------
    certificate : dict
        From JSON.

    Returns
    -------
    str
        The place; empty if it has it.

    Examples
    --------
    >>> misfit_of_certificate({"schema": "parkproof-certificate-1"})
    'its keys'
    """
    top = {"schema", "claim", "assumptions", "law", "lyapunov", "sampled", "measured", "method"}
    law: Any = certificate.get("law")
    given: Any = certificate.get("assumptions")
    wholes = {
        "its keys": set(certificate) == top | {"versions", "digest"},
        "law": type(law) is dict and type(law.get("name")) is str and law["name"] in BY_LAW,
        "assumptions": type(given) is dict and type(given.get("starts")) is dict,
    }
    for place, whole in wholes.items():
        if not whole:
            return place
    own, approach = BY_LAW[law["name"]]
    starts = next((names for names in STARTS if set(names) == set(given["starts"])), STARTS[0])
    ranges = {"alpha": (2, 2), "gamma": (2, 2), "disturbance": 2, "b2": 2}
    shapes = {
        "claim": CLAIM,
        "law": {"name": tuple(BY_LAW), **LAW, **own},
        "assumptions": {**ranges, "starts": dict.fromkeys(starts, 2)},
        "lyapunov": {"approach": approach, "hold": TWO_CHAIN, "return": TWO_CHAIN},
    }
    for section, shape in shapes.items():
        if found := misfit(certificate[section], shape, section):
            return found
    return _misfit_of_measured(certificate["sampled"], certificate["measured"])


def _misfit_of_measured(sampled: Any, measured: Any) -> str:
    """What was measured is printed beside the theorem, so it must not look like a part of it."""
    if type(sampled) is not list or type(measured) is not dict:
        return "sampled or measured"
    for key, value in measured.items():
        parts = value if type(value) is list else [value]
        plain = all(part is None or _fits(part, 0) or _fits(part, WORD) for part in parts)
        if not plain or not WORD.fullmatch(key):
            return "measured"
    return ""
