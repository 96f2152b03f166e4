"""How to cite the paper and this software."""

from parkproof import __version__

_BIBTEX = """\
@article{{Chen2014,
  author  = {{Chen, Hua and Ding, Shihong and Chen, Xi and Wang, Lihua and Zhu, Changping and
             Chen, Wen}},
  title   = {{Global Finite-time Stabilization for Nonholonomic Mobile Robots Based on Visual
             Servoing}},
  journal = {{International Journal of Advanced Robotic Systems}},
  volume  = {{11}},
  pages   = {{180}},
  year    = {{2014}},
  doi     = {{10.5772/59307}}
}}

@software{{Parkproof,
  author  = {{{{The Parkproof authors}}}},
  title   = {{Parkproof: parking a wheeled robot under one uncalibrated camera, in finite time}},
  version = {{{version}}},
  license = {{BSD-3-Clause}}
}}
"""


def citation() -> str:
    """Give BibTeX entries of the paper and of this software.

    Returns
    -------
    str
        Two entries: the paper first.

    Examples
    --------
    >>> print(citation())
    @article{Chen2014,
    ...
    """
    return _BIBTEX.format(version=__version__)
