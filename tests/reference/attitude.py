"""The complementary filter as a recursion in literal lines, and the exact variance of its error."""

import math

import numpy as np
from scipy.linalg import solve_discrete_lyapunov
from scipy.spatial.transform import Rotation


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


def variance(gains, gyro, tilt):
    """Of the settled angle, by Lyapunov's equation of (angle, bias); white noises and gains per sample interval."""
    keep, slow = math.exp(-gains[0]), gains[1]
    order = 2 if slow else 1
    A = np.array([[keep, -keep], [slow, 1 - slow]])[:order, :order]
    B = np.array([[keep * gyro, (1 - keep) * tilt], [slow * gyro, -slow * tilt]])[:order]
    return solve_discrete_lyapunov(A, B @ B.T)[0, 0]
