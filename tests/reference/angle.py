"""The estimator of the angle sensors as textbooks print it, in a few literal lines, and the paper's table."""

import math

import numpy as np

EARTH_RATE = 7.292115e-5
TURN = 300.0

PAPER = {  # errors of the eight amplitudes by range of h, relative units, in the order of the printed table
    "0-7": (0.3, 0.1, 0.1, 0.2, 0.05, 0.009, 0.2, 0.09), "7-14": (0.04, 0.2, 0.2, 0.03, 0.05, 0.03, 0.08, 0.02),
    "14-20": (0.02, 0.1, 0.1, 0.1, 0.02, 0.03, 0.03, 0.01), "20-25": (0.08, 0.05, 0.06, 0.06, 0.06, 0.08, 0.03, 0.05),
    "25-29": (0.3, 0.2, 0.06, 0.2, 0.09, 0.03, 0.02, 0.002), "29-30": (0.6, 1.4, 0.2, 0.2, 0.3, 0.1, 0.5, 0.06),
}  # fmt: skip
PAPER_SUMS = (1.05, 0.65, 0.41, 0.47, 0.9, 3.36)


def row(t, latitude, law, orders=None, *, nuisance=("ax", "az", "A1", "A2", "A3"), turn=TURN):
    """The row of observation at one instant, written out; orders by angle, 128 and 256 of both by default."""
    H = EARTH_RATE * t
    h = math.asin(math.cos(latitude) * math.sin(H))
    q = math.pi / 2 + H if law == "linear" else math.atan2(math.cos(H), -math.sin(latitude) * math.sin(H))
    f1 = -math.cos(latitude) * math.sin(h) * math.cos(q) + math.sin(latitude) * math.cos(h)
    f2 = -math.cos(latitude) * math.cos(h) * math.sin(q)
    g, rho = f2 / math.cos(h), 2 * math.pi * t / turn
    a = []
    for f, angle, name in ((f1, h, "h"), (f2, q, "q")):
        for k in (orders or {"h": (128, 256), "q": (128, 256)}).get(name, ()):
            a += [f * math.sin(k * angle), f * math.cos(k * angle)]
    beside = {"ax": f1 * math.cos(rho) + g * math.sin(rho), "az": -f1 * math.sin(rho) + g * math.cos(rho),
              "A1": math.sin(H), "A2": math.cos(H), "A3": t, "A0": 1.0}  # fmt: skip
    return np.array([*a, *(beside[name] for name in nuisance)])


def difference(t, latitude, errors):
    """Cosine between the vectors by the readings r = angle + error(r), less the true one, 0; errors as {k: (S, C)}."""
    H = EARTH_RATE * t
    h, q = math.asin(math.cos(latitude) * math.sin(H)), math.atan2(math.cos(H), -math.sin(latitude) * math.sin(H))
    read = []
    for angle, name in ((h, "h"), (q, "q")):
        r = angle
        for _ in range(20):
            r = angle + sum(S * math.sin(k * r) + C * math.cos(k * r) for k, (S, C) in errors.get(name, {}).items())
        read.append(r)
    h, q = read
    return math.cos(h) * math.cos(latitude) * math.cos(q) + math.sin(h) * math.sin(latitude)


def least_squares(rows, z, sigma=None, prior=None):
    """Estimate and standard errors, of scaled columns; a prior stands as further rows."""
    n, p = rows.shape
    if sigma is None:
        length = np.linalg.norm(rows, axis=0)
        left = z - rows / length @ np.linalg.lstsq(rows / length, z, rcond=None)[0]
        sigma = math.sqrt(left @ left / (n - p))
    if prior is not None:
        rows, z = np.vstack([rows, sigma * np.diag(1 / np.asarray(prior))]), np.append(z, np.zeros(p))
    length = np.linalg.norm(rows, axis=0)
    Q, R = np.linalg.qr(rows / length)
    inverse = np.linalg.inv(R)
    return inverse @ (Q.T @ z) / length, sigma * np.linalg.norm(inverse, axis=1) / length


def kalman(rows, z, sigma, prior):
    """Kalman filter without prediction, covariance in Joseph's form: estimate, covariance, innovations."""
    x, P = np.zeros(len(prior)), np.diag(np.asarray(prior, dtype=float) ** 2)
    innovations = []
    for a, value in zip(rows, z, strict=True):
        s = a @ P @ a + sigma**2
        k = P @ a / s
        innovations.append((value - a @ x) / math.sqrt(s))
        x = x + k * (value - a @ x)
        J = np.eye(len(x)) - np.outer(k, a)
        P = J @ P @ J.T + sigma**2 * np.outer(k, k)
    return x, P, np.array(innovations)
