"""The one exception that a user's input can cause, and one for being stopped.

What happens during a run is not an error: see `parkproof.simulation.outcome`.
"""


class StoppedError(KeyboardInterrupt):
    """Ctrl-C or a request to terminate, with what is kept and how to go on.

    Examples
    --------
    >>> isinstance(StoppedError("10 of 20 trials are there"), KeyboardInterrupt)
    True
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
