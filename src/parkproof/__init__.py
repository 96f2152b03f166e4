"""Park a wheeled robot under one uncalibrated camera, in finite time.

The public names are listed once, in `__init__.pyi`, and loaded when first used: so importing this
package is quick.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
