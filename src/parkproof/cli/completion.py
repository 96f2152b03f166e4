"""``parkproof completion``: completion scripts of shells."""

from typing import Literal

from parkproof.errors import InputError


def completion(
    shell: Literal["bash", "zsh", "fish", "powershell"] | None = None,
    /,
    *,
    install: bool = False,
) -> int:
    """Print or install the completion script of a shell.

    Installing writes the script to where the shell looks for it, and names it in the shell's
    start-up file where that is needed.

    Parameters
    ----------
    shell : "bash", "zsh", "fish" or "powershell", optional
        The shell; default the one in use.
    install : bool
        Install the script instead of printing it.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    InputError
        If the shell is not given and cannot be told.

    Examples
    --------
    >>> completion("bash")
    # ...
    0
    """
    from cyclopts.completion import ShellDetectionError

    from parkproof.cli import command_line
    from parkproof.cli.console import stdout_console, write

    app = command_line()
    try:
        if not install:
            write(app.generate_completion(shell=shell))
            return 0
        path = app.install_completion(shell=shell)
    except ShellDetectionError as error:
        raise InputError("the shell cannot be told; name it: parkproof completion bash") from error
    stdout_console().print(f"Wrote {path}; it works in shells started from now on", soft_wrap=True)
    return 0
