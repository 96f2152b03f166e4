"""Pictures of a run of the laboratory: those that a simulated run has."""

from pathlib import Path
from typing import TYPE_CHECKING

from parkproof.report.figures import paper_figures, plot
from parkproof.report.path_picture import path_picture

if TYPE_CHECKING:
    from parkproof.lab.summary import LabRun


def lab_pictures(run: "LabRun", directory: Path | str) -> list[Path]:
    """Draw the path in the image, the overview, and the paper's figures as far as they apply.

    Parameters
    ----------
    run : LabRun
        The run.
    directory : Path or str
        Where they go; it exists.

    Returns
    -------
    list of Path
        The files; none if the robot was never seen.

    Examples
    --------
    >>> [path.name for path in lab_pictures(lab_run, directory)][:3]
    ['path.png', 'path.svg', 'overview.png']
    """
    if not run.samples:
        return []
    files = [Path(directory) / name for name in ("path.png", "path.svg", "overview.png")]
    for path in files[:2]:
        path_picture(run, path)
    plot(run, files[2])
    return files + paper_figures(run, directory)
