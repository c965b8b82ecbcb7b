"""Expectation and covariance of every statistic under any model."""
