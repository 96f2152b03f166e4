"""``parkproof schema``: the JSON schemas of the files."""

from typing import Literal


def schema(kind: Literal["scenario", "certificate"] = "scenario", /) -> int:
    """Print the JSON schema of scenario files or certificates, for editors.

    Parameters
    ----------
    kind : "scenario" or "certificate"
        Of which files; default scenario.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> schema()
    {
    ...
    0
    """
    from parkproof.cli.console import write

    if kind == "certificate":
        from importlib import resources

        file = resources.files("parkproof.proof").joinpath("certificate.schema.json")
        write(file.read_text(encoding="utf-8"))
        return 0
    from parkproof.scenario_file import schema_text

    write(schema_text())
    return 0
