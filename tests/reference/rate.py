"""Rate estimators as their sources print them, and by brute force."""

import math

import numpy as np


def hamming(rates):
    """Enin, Saneev 2017: Omega = sum a_i omega_i, a_i = C (0.54 - 0.46 cos(2 pi i / (N - 1)))."""
    N = len(rates)
    a = [0.54 - 0.46 * math.cos(2 * math.pi * i / (N - 1)) for i in range(N)]
    return math.fsum(x * w for x, w in zip(a, rates, strict=True)) / math.fsum(a)


def regression(angles, rate):
    """Enin, Saneev 2017, (1): Omega = 6 (2 sum i theta_i - (n + 1) sum theta_i) / (n (n - 1) (n + 1)) f."""
    n = len(angles)
    first = math.fsum((i + 1) * theta for i, theta in enumerate(angles))
    return 6 * (2 * first - (n + 1) * math.fsum(angles)) / (n * (n - 1) * (n + 1)) * rate


def lines(angles, rate, count):
    """Slopes of `count` lines, each through len(angles) - count + 1 points and one point later."""
    length = len(angles) - count + 1
    return [regression(angles[k : k + length], rate) for k in range(count)]


def best_linear(C, aim=None, settled=None, waves=()):
    """Dense: weights of sum 1 with the least w'Cw, or the least error against an aim, which sees waves as they do."""
    n = len(C)
    X = np.column_stack([np.ones(n), *waves])
    M = np.block([[C, X], [X.T, np.zeros((X.shape[1],) * 2)]])
    right = np.append(np.zeros(n), 1.0) if aim is None else np.append((C - settled) @ aim, X.T @ aim)
    return np.linalg.solve(M, right)[:n]


def weights(estimator, n):
    """Of a linear estimator: what it makes of a rate of 1 in one sample."""
    return np.array([estimator(rates) for rates in np.eye(n)])


def misfit(y, slope, phase):
    """Enin, Saneev 2017, (2): sum (phi_e - phi)^2 with the staircase floor(slope t + phase), t = 0, 1, 2 ..."""
    return float(((y - np.floor(slope * np.arange(len(y)) + phase)) ** 2).sum())


def best_phase(y, slope):
    """Least misfit of a slope over all phases: every phase at which one sample steps up is tried."""
    u = slope * np.arange(len(y))
    whole = np.floor(u)
    order = np.argsort(whole - u, kind="stable")
    d = y - whole
    up = np.concatenate(([0.0], np.cumsum(d[order])))
    j = np.arange(len(y) + 1)
    B = np.rint((d.sum() - j) / len(y))
    return float(((d * d).sum() - 2 * up + j - 2 * B * (d.sum() - j) + len(y) * B * B).min())


def global_staircase(y, reach):
    """Least misfit of all staircases with a slope within `reach` of the regression's.

    Between two neighbouring slopes at which some two samples step at the same phase, the misfit is that of the middle.
    """
    n = len(y)
    t = np.arange(n) - (n - 1) / 2
    slope = t @ y / (t @ t)
    meeting = [np.arange(math.floor((slope - reach) * k), math.ceil((slope + reach) * k) + 1) / k for k in range(1, n)]
    slopes = np.unique(np.concatenate([*meeting, [slope - reach, slope + reach]]))
    slopes = slopes[(slopes >= slope - reach) & (slopes <= slope + reach)]
    gaps = np.diff(slopes)
    middles = (slopes[:-1] + gaps / 2)[gaps > 1e-12]
    return min(best_phase(y, a) for a in middles)


def descent(y, steps, step=0.3):
    """Enin, Saneev 2017, (3) to (5): slope, sample by sample, after each step from the interval's own count.

    The paper says nothing of the gradient of a function that is constant almost everywhere: it is taken as the slope of
    a straight line through misfits at `step` pulses to both sides, the least F(z) from a table of z.
    """
    n = len(y) - 1
    x = np.array([y[-1], 0.5])  # U T and the phase, pulses
    path = [x[0] / n]
    for _ in range(steps):
        values = [[misfit(y, *(x + sign * h) / (n, 1)) for sign in (1, -1)] for h in step * np.eye(2)]
        gradient = np.array([plus - minus for plus, minus in values]) / (2 * step)
        x = min(
            [x, *(x - z / n * gradient for z in np.geomspace(0.1, 10, 25))], key=lambda x: misfit(y, x[0] / n, x[1])
        )
        path.append(x[0] / n)
    return path


def swings(amplitudes, periods, walk, n, duration):
    """Covariance of n rates under swings of the angle, each of a random phase, and a random walk, per root of s."""
    t = np.linspace(0, duration, n + 1)
    lag = np.subtract.outer(t, t)
    angle = sum(a**2 / 2 * np.cos(2 * np.pi / period * lag) for a, period in zip(amplitudes, periods, strict=True))
    return np.diff(np.diff(angle, axis=0), axis=1) * (n / duration) ** 2 + walk**2 * n / duration * np.eye(n)


def turnaround_kick(gyro, phase, steps=20_000):
    """Kick of the phase at one turning point of the dither, by Runge-Kutta, rad; of the shape of `phase`.

    d psi / dt = (2 pi / K) Omega_D cos(omega t) - (2 pi / K) Omega_L sin(psi), over half a dither period about the
    turning point, less the same without lock-in. `gyro` is (K, Omega_L, Omega_D, omega), rad and s; `phase` is that at
    the turning point without lock-in.
    """
    K, lock_in, dither, omega = gyro
    k = 2 * math.pi / K
    h = math.pi / omega / steps

    def free(t):
        return k * dither / omega * (math.sin(omega * t) - 1.0)

    def slope(t, kick):
        return -k * lock_in * np.sin(phase + free(t) + kick)

    t, kick = 0.0, np.zeros_like(phase)
    for _ in range(steps):
        a = slope(t, kick)
        b = slope(t + h / 2, kick + h / 2 * a)
        c = slope(t + h / 2, kick + h / 2 * b)
        kick = kick + h / 6 * (a + 2 * b + 2 * c + slope(t + h, kick + h * c))
        t += h
    return kick
