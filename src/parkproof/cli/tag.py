"""``parkproof tag``: a tag to print."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def tag(
    *,
    tag_id: Annotated[int, Parameter(name="--id")] = 0,
    out: Path = Path("tag.pdf"),
    side: float = 0.1,
    page: str = "A4",
    overwrite: bool = False,
) -> int:
    """Make a page with a tag to print, to scale.

    The tag is of the family tag36h11 of AprilTag. The page says its id and side, shows the robot's
    forward and the tag's centre, and has a ruler of 100 mm to check the printer.

    Parameters
    ----------
    tag_id : int
        Which tag, 0 to 586; default 0. Each robot in view needs its own.
    out : Path
        File to write, .pdf, .svg or .png; default tag.pdf.
    side : float
        Side of the black square in m, default 0.1.
    page : str
        A3, A4, A5 or letter; default A4.
    overwrite : bool
        Replace the file if there is one.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> tag(tag_id=7, out=Path("tag.png"))
    Wrote tag.png; print it at 100 %, and show the robot parked to: parkproof teach --tag-id 7
    0
    """
    from parkproof.cli.console import stdout_console
    from parkproof.cli.files import check_target, write_file
    from parkproof.lab.tag_sheet import check_ending, tag_sheet

    ending = check_ending(out)
    check_target(out, overwrite=overwrite)
    write_file(out, tag_sheet(tag_id, ending, side=side, page=page), overwrite=overwrite)
    stdout_console().print(
        f"Wrote {out}; print it at 100 %, and show the robot parked to: parkproof teach --tag-id "
        f"{tag_id}",
        soft_wrap=True,
    )
    return 0
