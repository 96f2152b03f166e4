"""``parkproof schema``: the JSON schema of scenario files."""


def schema() -> int:
    """Print the JSON schema of scenario files, for editors.

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
    from parkproof.scenario_file import schema_text

    write(schema_text())
    return 0
