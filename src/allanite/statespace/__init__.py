"""Models of a sensor's error for Kalman filters: states, transition, covariances."""

from .space import StateSpace as StateSpace, state_space as state_space
