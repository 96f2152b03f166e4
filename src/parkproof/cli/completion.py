"""``parkproof completion``: completion scripts of shells."""

from typing import Literal

from parkproof.errors import InputError


def completion(
    action: Literal["show", "install"] = "show",
    /,
    *,
    shell: Literal["bash", "zsh", "fish", "powershell"] | None = None,
) -> int:
    """Print or install the completion script of a shell.

    Installing writes the script to where the shell looks for it, and names it in the shell's
    start-up file where that is needed.

    Parameters
    ----------
    action : "show" or "install"
        Print the script (default), or install it.
    shell : "bash", "zsh", "fish" or "powershell", optional
        The shell; default the one in use.

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
    >>> completion("show", shell="bash")
    # ...
    0
    """
    from cyclopts.completion import ShellDetectionError

    from parkproof.cli import command_line
    from parkproof.cli.console import stdout_console, write

    app = command_line()
    try:
        if action == "show":
            write(app.generate_completion(shell=shell))
            return 0
        path = app.install_completion(shell=shell)
    except ShellDetectionError as error:
        raise InputError("the shell in use cannot be told; add for example --shell bash") from error
    stdout_console().print(f"Wrote {path}; it works in shells started from now on", soft_wrap=True)
    return 0
