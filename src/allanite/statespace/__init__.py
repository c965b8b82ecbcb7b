"""Models of a sensor's error as Kalman filters want them: states, transition, covariances."""

from .space import StateSpace as StateSpace
from .space import state_space as state_space
