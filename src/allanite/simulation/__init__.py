"""Records with known truth: noise of a model, faults of a channel, a ring laser gyro, a gimbal."""

from . import faults as faults
