"""The filters of roll and pitch, a table and how each is run; rotation vectors with coning correction."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from allanite.extending import DataError, FloatArray, constructed, public, say, spelled

from .inertial import Inertial
from .loop import Loop, SensorNoise
from .optimum import best_kalman, best_loop, best_second_order


@public
def rotation_vectors(increments: FloatArray) -> FloatArray:
    """Rotation vectors over pairs of increments, corrected for coning.

    Parameters
    ----------
    increments : array, shape (n, 3)
        Angle increments, rad, in the axes of the body. One beyond the last pair is left out.

    Returns
    -------
    array, shape (n // 2, 3)

    Raises
    ------
    DataError
        The increments do not have the shape (n, 3).

    References
    ----------
    J. E. Bortz, IEEE Trans. AES-7 (1971) 61; R. B. Miller, J. Guidance 6 (1983) 287.

    Examples
    --------
    >>> rotation_vectors(np.array([[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0]]))[0].round(12).tolist()
    [0.001, 0.001, 6.66667e-07]
    """
    increments = np.ascontiguousarray(increments, dtype=np.float64)
    if increments.ndim != 2 or increments.shape[1] != 3:
        raise DataError(f"increments have the shape (n, 3), not {increments.shape}")
    first, second = increments[: len(increments) // 2 * 2].reshape(-1, 2, 3).swapaxes(0, 1)
    return np.asarray(first + second + 2 / 3 * np.cross(first, second))


@public
def attitudes(vectors: FloatArray, start: FloatArray) -> FloatArray:
    """Attitude after each rotation vector, from `start`: quaternions, shape (n, 4), scalar first.

    They rotate from the axes of the body to those of the start's reference; with
    ``scipy.spatial.transform.Rotation.from_quat(q, scalar_first=True)`` they become matrices or angles.

    Raises
    ------
    DataError
        The vectors do not have the shape (n, 3), or the start not (4,).
    """
    from allanite.kernels.attitude import rotated

    vectors, start = np.ascontiguousarray(vectors, dtype=np.float64), np.array(start, dtype=np.float64)
    if vectors.ndim != 2 or vectors.shape[1] != 3:
        raise DataError(f"vectors have the shape (n, 3), not {vectors.shape}")
    if start.shape != (4,):
        raise DataError(f"start is a quaternion of 4 numbers, not of the shape {start.shape}")
    quaternions = np.empty((len(vectors), 4))
    rotated(vectors, start, quaternions)
    return quaternions


Angles = tuple[FloatArray, int]
"""Roll and pitch, rad, shape (n, 2), and the number of samples for which the gyros alone were used."""


@constructed
@dataclass(frozen=True)
class Setting:
    """Settings of a filter.

    Attributes
    ----------
    loop : Loop
        Gains: the angle's k1 = 1 / time constant, and the bias's k2.
    beta : float, optional
        Gain of Madgwick's filter, rad/s; by default as fast as the time constant in the noise of the accelerometers.
    gate : float, optional
        Innovation of the angle, rad, above which the accelerometers are ignored.
    norm_gate : float, optional
        Deviation of the size of the specific force from its median, relative, above which they are ignored.
    """

    loop: Loop
    beta: float | None = None
    gate: float | None = None
    norm_gate: float | None = None

    @property
    def gates(self) -> FloatArray:
        """Both gates, infinite where there is none."""
        return np.array([math.inf if g is None else g for g in (self.gate, self.norm_gate)])


@dataclass(frozen=True)
class AttitudeFilter:
    """A row of `FILTERS`."""

    # name, title, formula, reference: name, description, LaTeX formula and source
    name: str
    title: str
    formula: str
    reference: str
    run: Callable[[Inertial, Setting], Angles]
    looped: bool = False  # whether `predicted_error` holds for it: a linear filter with the gains of a `Loop`
    estimates: bool = False  # whether it estimates the gyro bias
    best: Callable[[Sequence[SensorNoise]], Loop] = best_loop  # its gains for the noise of roll and of pitch


def _complementary(data: Inertial, setting: Setting) -> Angles:
    from allanite.kernels.attitude import complementary

    loop, dt = setting.loop, data.interval
    loop.demand_sampled(dt)
    gains = np.array([math.exp(-loop.k1 * dt), loop.k2 * dt, dt, data.gravity, *setting.gates])
    angles = np.empty((len(data.gyro), 2))
    held, steep = complementary(data.gyro, data.force, gains, data.start, angles)
    if steep >= 0:
        raise DataError(f"the pitch is within 1 degree of 90 at {steep * dt:.6g} s, where roll has no meaning; use a "
                        f"filter of quaternions: {spelled('--filter mahony', 'method=...')}")  # fmt: skip
    return angles, held


def _steered(name: str, data: Inertial, setting: Setting, first: float, second: float) -> Angles:
    """A filter of quaternions with its two gains."""
    from allanite.kernels import attitude

    angles = np.empty((len(data.gyro), 2))
    gains = np.array([first, second, data.interval, data.gravity, *setting.gates])
    return angles, getattr(attitude, name)(data.gyro, data.force, gains, quaternion(data.start), angles)


def _tilts(up: FloatArray) -> FloatArray:
    """Roll and pitch of vectors that point up, shape (n, 2)."""
    from allanite.kernels.attitude import tilts

    angles = np.empty((len(up), 2))
    tilts(up, angles)
    return angles


def _bortz(data: Inertial, setting: Setting) -> Angles:
    w, a, b, c = attitudes(rotation_vectors(data.gyro * data.interval), quaternion(data.start)).T
    angles = _tilts(np.stack([2 * (a * c - w * b), 2 * (w * a + b * c), 1 - 2 * (a * a + b * b)], axis=1))
    # an attitude holds at the end of its pair of samples; the sample before takes that of the pair before
    index = (np.arange(len(data.gyro)) + 1) // 2 - 1
    return np.where(index[:, None] < 0, data.start, angles[np.maximum(index, 0)]), len(index)


def quaternion(angles: FloatArray) -> FloatArray:
    """The attitude with this roll and pitch, rad, and no yaw; scalar first."""
    (r, p) = angles / 2
    sr, cr, sp, cp = math.sin(r), math.cos(r), math.sin(p), math.cos(p)
    return np.array([cr * cp, sr * cp, cr * sp, -sr * sp])


def beta_of(data: Inertial, setting: Setting) -> float:
    """Madgwick's gain: as given, or as fast as the time constant in noise."""
    # Its correction turns at 2 beta whatever the error. In noise of the tilt with the standard deviation s of each
    # angle that is on average sqrt(pi / 8) / s of the error, so that beta = s / (sqrt(pi / 2) time constant).
    if setting.beta is not None:
        return setting.beta
    steps = np.diff(data.force[:, :2], axis=0) / data.gravity
    return math.sqrt(float((steps**2).mean()) / 2) / (math.sqrt(math.pi / 2) * setting.loop.time_constant)


FILTERS: dict[str, AttitudeFilter] = {
    row.name: row
    for row in (
        AttitudeFilter("complementary", say("complementary filter of first order"),
                       r"\hat\theta = \frac{\tau s}{\tau s + 1} \int \omega + \frac{1}{\tau s + 1} \theta_a",
                       "Higgins, IEEE Trans. AES-11 (1975) 321", _complementary, looped=True),
        AttitudeFilter("second-order", say("complementary filter of second order, which estimates the gyro bias"),
                       r"\dot\theta = \omega - b + k_1 (\theta_a - \theta), \quad \dot b = -k_2 (\theta_a - \theta)",
                       "Brown and Hwang, Introduction to Random Signals (1997)", _complementary, looped=True,
                       estimates=True, best=best_second_order),
        AttitudeFilter("kalman", say("steady Kalman filter for angle and rate random walk"),
                       r"k_1 = \sqrt{N^2 + 2 K \sqrt{S_a}} / \sqrt{S_a}, \quad k_2 = K / \sqrt{S_a}",
                       say("the filter of second order with the gains of the Riccati equation"), _complementary,
                       looped=True, estimates=True, best=best_kalman),
        AttitudeFilter(
            "mahony", say("Mahony's filter, kP = k1 and kI = k2"),
            r"\dot q = \tfrac{1}{2} q \otimes (\omega - b + k_P\, a \times v), \quad \dot b = -k_I\, a \times v",
            "Mahony et al., IEEE Trans. AC-53 (2008) 1203",
            lambda data, setting: _steered("mahony", data, setting, setting.loop.k1, setting.loop.k2), looped=True,
        ),
        AttitudeFilter("madgwick", say("Madgwick's filter, which corrects at a constant rate of 2 beta"),
                       r"\dot q = \tfrac{1}{2} q \otimes \omega - \beta \nabla f / |\nabla f|",
                       "Madgwick et al., ICORR (2011)",
                       lambda data, setting: _steered("madgwick", data, setting, beta_of(data, setting), 0.0)),
        AttitudeFilter("bortz", say("gyros alone, rotation vector with coning correction"),
                       r"\phi = \theta_1 + \theta_2 + \tfrac{2}{3} \theta_1 \times \theta_2",
                       "Bortz, IEEE Trans. AES-7 (1971) 61", _bortz),
        AttitudeFilter("accelerometer", say("accelerometers alone"), r"\theta_a = \arctan(-f_x / \sqrt{f_y^2 + f_z^2})",
                       say("the tilt of the specific force"), lambda data, setting: (_tilts(data.force), 0)),
    )
}  # fmt: skip
