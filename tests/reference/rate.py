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


def descent(y, step=0.02, most=200):
    """The paper's steepest descent from the regression, in the heights of the line's two ends.

    The gradient of the misfit is zero almost everywhere, and the paper says nothing of a step: differences over `step`
    pulses stand in for it, and the line search halves from half a pulse.
    """
    n = len(y)
    right = np.arange(n) / (n - 1)
    t = np.arange(n) - (n - 1) / 2
    slope = t @ y / (t @ t)
    middle = y.mean() + 0.5

    def phi(p, q):
        ends = middle - slope * (n - 1) / 2 + p, middle + slope * (n - 1) / 2 + q
        return float(((y - np.floor(ends[0] + (ends[1] - ends[0]) * right)) ** 2).sum())

    p, q, best = 0.0, 0.0, phi(0.0, 0.0)
    for _ in range(most):
        gradient = np.array([phi(p + step, q) - phi(p - step, q), phi(p, q + step) - phi(p, q - step)])
        size = float(np.hypot(*gradient))
        if size == 0:
            break
        found = min((phi(*(np.array([p, q]) - z * gradient / size)), z) for z in 0.5 ** np.arange(1, 14))
        if found[0] >= best:
            break
        best = found[0]
        p, q = np.array([p, q]) - found[1] * gradient / size
    return best


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
