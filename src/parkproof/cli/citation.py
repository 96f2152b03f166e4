"""``parkproof citation``: how to cite."""


def citation() -> int:
    """Print BibTeX for the paper and for this software.

    Returns
    -------
    int
        Exit status.

    Examples
    --------
    >>> citation()
    @article{Chen2014,
    ...
    0
    """
    from parkproof.citation import citation as bibtex
    from parkproof.cli.console import write

    write(bibtex())
    return 0
