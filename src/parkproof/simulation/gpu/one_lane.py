"""The lanes' package loaded a second time, with blocks of one lane.

What a thread of a graphics processor carries out is a block of one trial: the same modules, in
which `BLOCK` is 1 and every loop over lanes is a single pass. They import one another relatively,
so that loaded under another name they find each other.
"""

import sys
from functools import cache
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from types import ModuleType

from parkproof.simulation import lanes

NAME = "parkproof.simulation.one_lane"


@cache
def one_lane(module: str) -> ModuleType:
    """Give a module of the lanes, for blocks of one lane.

    Parameters
    ----------
    module : str
        Its name in `parkproof.simulation.lanes`.

    Returns
    -------
    module
        Not that of the same name in `parkproof.simulation.lanes`.

    Examples
    --------
    >>> one_lane("buffer").BLOCK
    1
    """
    if NAME not in sys.modules:
        spec = spec_from_file_location(
            NAME, lanes.__file__, submodule_search_locations=list(lanes.__path__)
        )
        if spec is None or spec.loader is None:
            raise ImportError(f"{lanes.__file__} cannot be loaded a second time")
        sys.modules[NAME] = module_from_spec(spec)
        spec.loader.exec_module(sys.modules[NAME])
    return import_module(f"{NAME}.{module}")
