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
    from parkproof.cli.console import write
    from parkproof.references import citation as bibtex

    write(bibtex())
    return 0
