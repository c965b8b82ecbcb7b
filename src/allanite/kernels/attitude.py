"""Filters of roll and pitch, sample by sample. Angles in rad; specific force points up at rest."""

import math

import numpy as np

from .compiling import kernel

FREE_FALL = 0.1
"""Specific force, relative to the reference, below which it tells nothing of the vertical."""

STEEP = math.cos(math.radians(89.0))
"""Cosine of the pitch below which roll has no meaning."""


@kernel
def _tilt(x, y, z):  # type: ignore[no-untyped-def]
    return math.atan2(y, z), math.atan2(-x, math.hypot(y, z))


@kernel
def _wrapped(angle):  # type: ignore[no-untyped-def]
    return angle - 2 * math.pi * math.floor((angle + math.pi) / (2 * math.pi))


@kernel
def tilts(force, found):  # type: ignore[no-untyped-def]
    """Roll and pitch from specific force alone, shape (n, 2)."""
    for k in range(force.shape[0]):
        found[k, 0], found[k, 1] = _tilt(force[k, 0], force[k, 1], force[k, 2])


@kernel
def _advance(roll, pitch, rates, dt):  # type: ignore[no-untyped-def]
    """Roll and pitch after a step with constant rates, by the midpoint rule."""
    p, q, r = rates[0], rates[1], rates[2]
    a, b = roll, pitch
    for step in (0.5, 1.0):
        s, c = math.sin(a), math.cos(a)
        da = p + math.tan(b) * (q * s + r * c)
        db = q * c - r * s
        a, b = roll + step * dt * da, pitch + step * dt * db
    return a, b


@kernel
def usable(force, k, gravity, norm_gate):  # type: ignore[no-untyped-def]
    """Whether a specific force is one that the vertical can be taken from."""
    size = math.sqrt(force[k, 0] ** 2 + force[k, 1] ** 2 + force[k, 2] ** 2)
    return size > FREE_FALL * gravity and abs(size - gravity) <= norm_gate * gravity


@kernel
def complementary(gyro, force, gains, start, found):  # type: ignore[no-untyped-def]
    """Filter of first or second order, shape (n, 2); the number of samples held, and where the pitch became steep.

    `gains` are alpha, k2 dt, dt, gravity, and the gates of the angle's innovation, rad, and of the norm of specific
    force, relative.
    """
    alpha, slow, dt, gravity = gains[0], gains[1], gains[2], gains[3]
    roll, pitch = start[0], start[1]
    roll_bias = pitch_bias = 0.0
    held = 0
    for k in range(gyro.shape[0]):
        if math.cos(pitch) < STEEP:
            return held, k
        roll, pitch = _advance(roll, pitch, gyro[k], dt)
        roll, pitch = roll - roll_bias * dt, pitch - pitch_bias * dt
        seen, pitched = _tilt(force[k, 0], force[k, 1], force[k, 2])
        a, b = _wrapped(seen - roll), pitched - pitch
        if usable(force, k, gravity, gains[5]) and max(abs(a), abs(b)) <= gains[4]:
            roll, pitch = roll + (1 - alpha) * a, pitch + (1 - alpha) * b
            roll_bias, pitch_bias = roll_bias - slow * a, pitch_bias - slow * b
        else:
            held += 1
        found[k, 0], found[k, 1] = _wrapped(roll), pitch
    return held, -1


@kernel
def _turned(q, p, y, r, dt):  # type: ignore[no-untyped-def]
    """Add half the product of a quaternion and a rate, times dt, to it."""
    w, a, b, c = q[0], q[1], q[2], q[3]
    h = dt / 2
    q[0] = w + h * (-a * p - b * y - c * r)
    q[1] = a + h * (w * p + b * r - c * y)
    q[2] = b + h * (w * y - a * r + c * p)
    q[3] = c + h * (w * r + a * y - b * p)


@kernel
def _normalize(q):  # type: ignore[no-untyped-def]
    size = math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)
    for i in range(4):
        q[i] /= size


@kernel
def _up(q):  # type: ignore[no-untyped-def]
    """The vertical in the body."""
    w, a, b, c = q[0], q[1], q[2], q[3]
    return 2 * (a * c - w * b), 2 * (w * a + b * c), 1 - 2 * (a * a + b * b)


@kernel
def _put(q, found, k):  # type: ignore[no-untyped-def]
    x, y, z = _up(q)
    found[k, 0], found[k, 1] = _tilt(x, y, z)


@kernel
def mahony(gyro, force, gains, q, found):  # type: ignore[no-untyped-def]
    """Mahony's filter with gains kP, kI, dt, gravity and gates; q is changed. The number of samples held."""
    kp, ki, dt, gravity = gains[0], gains[1], gains[2], gains[3]
    bx = by = bz = 0.0
    held = 0
    for k in range(gyro.shape[0]):
        p, y, r = gyro[k, 0], gyro[k, 1], gyro[k, 2]
        x, v, z = _up(q)
        fx, fy, fz = force[k, 0], force[k, 1], force[k, 2]
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        if usable(force, k, gravity, gains[5]):
            fx, fy, fz = fx / size, fy / size, fz / size
            ex, ey, ez = fy * z - fz * v, fz * x - fx * z, fx * v - fy * x
            if math.sqrt(ex * ex + ey * ey + ez * ez) <= math.sin(min(gains[4], math.pi / 2)):
                bx, by, bz = bx - ki * ex * dt, by - ki * ey * dt, bz - ki * ez * dt
                p, y, r = p + kp * ex, y + kp * ey, r + kp * ez
            else:
                held += 1
        else:
            held += 1
        _turned(q, p - bx, y - by, r - bz, dt)
        _normalize(q)
        _put(q, found, k)
    return held


@kernel
def madgwick(gyro, force, gains, q, found):  # type: ignore[no-untyped-def]
    """Madgwick's filter with gains beta, 0, dt, gravity and gates; q is changed. The number of samples held."""
    beta, dt, gravity = gains[0], gains[2], gains[3]
    slope = np.zeros(4)
    held = 0
    for k in range(gyro.shape[0]):
        fx, fy, fz = force[k, 0], force[k, 1], force[k, 2]
        size = math.sqrt(fx * fx + fy * fy + fz * fz)
        x, y, z = _up(q)
        slope[:] = 0.0
        angle = math.acos(min(1.0, max(-1.0, (x * fx + y * fy + z * fz) / max(size, 1e-300))))
        if usable(force, k, gravity, gains[5]) and angle <= gains[4]:
            a, b, c = x - fx / size, y - fy / size, z - fz / size
            w, i, j, m = q[0], q[1], q[2], q[3]
            slope[0] = -2 * j * a + 2 * i * b
            slope[1] = 2 * m * a + 2 * w * b - 4 * i * c
            slope[2] = -2 * w * a + 2 * m * b - 4 * j * c
            slope[3] = 2 * i * a + 2 * j * b
            norm = math.sqrt(slope[0] ** 2 + slope[1] ** 2 + slope[2] ** 2 + slope[3] ** 2)
            if norm > 0:
                slope /= norm
        else:
            held += 1
        _turned(q, gyro[k, 0], gyro[k, 1], gyro[k, 2], dt)
        for part in range(4):
            q[part] -= beta * slope[part] * dt
        _normalize(q)
        _put(q, found, k)
    return held


@kernel
def rotated(vectors, q, quaternions):  # type: ignore[no-untyped-def]
    """Attitudes after each of so many rotation vectors, shape (n, 4), scalar first; q is changed."""
    for k in range(vectors.shape[0]):
        p, y, r = vectors[k, 0], vectors[k, 1], vectors[k, 2]
        size = math.sqrt(p * p + y * y + r * r)
        half = math.sin(size / 2) / size if size > 1e-12 else 0.5
        c, p, y, r = math.cos(size / 2), half * p, half * y, half * r
        w, a, b, d = q[0], q[1], q[2], q[3]
        q[0] = w * c - a * p - b * y - d * r
        q[1] = w * p + a * c + b * r - d * y
        q[2] = w * y - a * r + b * c + d * p
        q[3] = w * r + a * y - b * p + d * c
        _normalize(q)
        quaternions[k] = q
