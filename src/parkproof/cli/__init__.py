"""The command line: one thin module a command, each imported only when it is called."""

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from parkproof import __version__
from parkproof.cli.errors import guarded, usage_error

if TYPE_CHECKING:
    from cyclopts import App

COMMANDS = {
    "reproduce": "Make Section 4 of the paper anew: its figures, and what its claims come to.",
    "park": "Carry out the run that a scenario file describes.",
    "campaign": "Carry out many trials, drawn from distributions, and keep a row of each.",
    "falsify": "Search for the run that breaks a claim, or comes nearest to a bound.",
    "init": "Write a commented scenario, campaign or other file that runs as it is.",
    "check": "Evaluate the paper's conditions (15)-(19) on the gains in a file.",
    "search": "Search for gains: Remark 3 as printed, a search that works, and Remark 4.",
    "design": "Find gains for given limits, with a proof that runs under them park.",
    "certify": "Prove that runs with given gains park, and write the proof as a certificate.",
    "verify": "Re-prove a certificate and print its theorem.",
    "camera": "Look through a camera, or measure how late it shows what the robot does.",
    "tag": "Make a page with a tag to print, to scale.",
    "teach": "Take the goal from one picture of the parked robot.",
    "lab": "Park a robot that a camera sees, from its pictures alone.",
    "replay": "Carry out one trial of a campaign, or a recorded run of the laboratory, again.",
    "schema": "Print the JSON schema of scenario files or certificates, for editors.",
    "citation": "Print BibTeX for the paper and for this software.",
    "completion": "Print or install the completion script of a shell.",
}
"""Every command in the order of the help page, with the first line of its own help.

Each is a function in the module of its name.
"""

EXIT_STATUSES = (
    "Exit status: 0 carried out; 1 if the answer is no (with --check, nothing is proved, a claim "
    "is broken); 2 bad input, or a file that cannot be read or written; 130 Ctrl-C; 143 terminated."
)


def command_line(called: str = "") -> "App":
    """Build the command line.

    Parameters
    ----------
    called : str
        The command that will be called, if that is known: its help is then all of its docstring.
        The others are imported neither for the help page nor for a call.

    Returns
    -------
    cyclopts.App
        Knows all `COMMANDS`.

    Examples
    --------
    >>> command_line().name
    ('parkproof',)
    """
    from cyclopts import App, Parameter

    from parkproof.cli.console import stdout_console

    app = App(
        name="parkproof",
        help="Park a wheeled robot under one uncalibrated camera, in finite time.",
        help_epilogue=EXIT_STATUSES,
        help_format="plaintext",
        version=f"parkproof {__version__}",
        default_parameter=Parameter(negative=(), show_default=False),
        console=stdout_console(),
        exit_on_error=False,
        print_error=False,
        suppress_keyboard_interrupt=False,
        result_action="return_value",
    )
    for place, (name, line) in enumerate(COMMANDS.items()):
        app.command(
            f"parkproof.cli.{name}:{name}",
            name=name,
            sort_key=place,
            help=None if name == called else line,
            help_format="markdown",  # which joins the lines of a docstring, but is slow to load
        )
    return app


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``parkproof``.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows the command's name; default what this process was given.

    Returns
    -------
    int
        The exit status: see `EXIT_STATUSES`. Nothing that a user can cause ends in an exception.

    Examples
    --------
    >>> main(["--version"])
    parkproof ...
    0
    """
    given = list(sys.argv[1:] if arguments is None else arguments)

    def call() -> int:
        from cyclopts import CycloptsError

        try:
            status = command_line(given[0] if given else "")(given)
        except CycloptsError as error:
            raise usage_error(error) from error
        return status if isinstance(status, int) else 0

    return guarded(call)
