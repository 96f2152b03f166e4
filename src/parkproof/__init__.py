"""Park a wheeled robot under one uncalibrated camera, in finite time."""

__version__ = "0.1.0"
