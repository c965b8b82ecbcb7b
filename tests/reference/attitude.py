"""The complementary filter as a recursion in literal lines, and the exact variance of its error."""

import math

import numpy as np
from scipy.spatial.transform import Rotation

from tests.reference.noise import autocovariance


def tilt(up):
    """Roll and pitch of a vector that points up in the body."""
    return np.array([math.atan2(up[1], up[2]), math.atan2(-up[0], math.hypot(up[1], up[2]))])


def recursion(gyro, force, gains, interval):
    """Roll and pitch, shape (n, 2), of rates and specific forces of shape (n, 3); it starts at the first second's mean.

    The vertical is turned by each rotation as a whole, the angles are then drawn towards the tilt of the specific force
    by 1 - exp(-k1 dt), and the biases of their rates by k2 dt: R. G. Brown, P. Y. C. Hwang, 1997.
    """
    angles, bias, found = tilt(force[: max(1, round(1 / interval))].mean(axis=0)), np.zeros(2), []
    for rates, f in zip(gyro, force, strict=True):
        (r, p) = angles
        up = np.array([-math.sin(p), math.sin(r) * math.cos(p), math.cos(r) * math.cos(p)])
        ahead = tilt(Rotation.from_rotvec(-rates * interval).apply(up)) - bias * interval
        innovation = tilt(f) - ahead
        angles = ahead + (1 - math.exp(-gains[0] * interval)) * innovation
        bias = bias - gains[1] * interval * innovation
        found.append(angles)
    return np.array(found)


def variance(gains, interval, sizes, n=4000):
    """Of one angle, once it has settled; sizes of the gyro's noise and of the tilt's, as in `noise`, per interval."""
    total = 0.0
    for sensor, size in enumerate(sizes):
        angle, bias, impulse = 0.0, 0.0, []
        for k in range(n):
            unit = np.eye(2)[sensor] * (k == 0)
            ahead = angle + unit[0] - bias * interval
            angle, bias = (ahead + (1 - math.exp(-gains[0] * interval)) * (unit[1] - ahead),
                           bias - gains[1] * interval * (unit[1] - ahead))  # fmt: skip
            impulse.append(angle)
        lags = np.correlate(impulse, impulse, "full")[n - 1 :]
        total += lags[0] * autocovariance(size, 1)[0] + 2 * lags[1:] @ autocovariance(size, n)[1:]
    return total
