"""A filter of the angle and the bias of a gyro, aided by an angle and then left alone: what it predicts, and its error.

The noise is the mean rate e_k of second k, which the filter integrates. Everything is written out: the two states,
their covariance, and how much of each e_k and of each error of the aid is in the estimates. Of the true noise the
covariance of the mean rates is needed; that of a drift follows from the structure function D of its angle.
"""

import numpy as np
from scipy.linalg import expm


def step(white, walk, time):
    """Transition of (angle, bias) in 1 s and the covariance of the noise: C. F. van Loan, IEEE Trans. AC 23 (1978) 395.

    `white` is N and `walk` the density of what drives the bias, which decays with the time constant `time`.
    """
    F = np.array([[0.0, 1.0], [0.0, -1 / time]])
    density = np.diag([white**2, walk**2])
    both = expm(np.block([[-F, density], [np.zeros((2, 2)), F.T]]))
    transition = both[2:, 2:].T
    return transition, transition @ both[:2, 2:]


def drift(D, n, before=60):
    """Covariance of the mean rates of n seconds, less the mean rate of so many seconds before them."""
    ends = np.arange(1.0 - before, n + 1)
    lag = np.abs(ends[:, None] - ends)
    C = (D(lag + 1) + D(np.abs(lag - 1)) - 2 * D(lag)) / 2
    less = np.eye(before + n)[before:]
    less[:, :before] = -1 / before
    return less @ C @ less.T


def judge(white, walk, truth, *, time=np.inf, aid=0.0, aided=1000, outages=(1, 10, 60, 300)):
    """Predicted standard deviations of the angle after the outages, and the actual ones; `truth` is the covariance."""
    F, Q = step(white, walk, time)
    P = np.diag([0.0, 1e-4])
    rate, error = np.zeros((2, aided)), np.zeros((2, aided))  # in the estimates of angle and bias
    for k in range(aided):
        P, rate, error = F @ P @ F.T + Q, F @ rate, F @ error
        gain = P[:, 0] / (P[0, 0] + aid**2)
        seen = np.where(np.arange(aided) <= k, 1.0, 0.0)
        innovation = np.array([seen - rate[0], (np.arange(aided) == k) - error[0]])
        rate, error = rate + np.outer(gain, innovation[0]), error + np.outer(gain, innovation[1])
        P = P - np.outer(gain, P[0])
    predicted, actual = [], []
    for t in range(1, max(outages) + 1):
        P, rate, error = F @ P @ F.T + Q, F @ rate, F @ error
        if t in outages:
            weights = np.concatenate((1 - rate[0], np.ones(t)))
            C = truth[: aided + t, : aided + t]
            predicted.append(P[0, 0] ** 0.5)
            actual.append((weights @ C @ weights + aid**2 * error[0] @ error[0]) ** 0.5)
    return np.array(predicted), np.array(actual)
