"""The one exception that a user's input can cause.

What happens during a run is not an error: see `parkproof.simulation.outcome`.
"""


class InputError(ValueError):
    """Something given from outside breaks a rule.

    Its message names what was given, the rule, the limit, and what to write instead, in one line;
    the command line prints it as it is.

    Examples
    --------
    >>> from parkproof.errors import InputError
    >>> try:
    ...     raise InputError("duration = -1: must be positive; write for example duration = 35.0")
    ... except ValueError as error:
    ...     print(error)
    duration = -1: must be positive; write for example duration = 35.0
    """
