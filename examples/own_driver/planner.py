"""A driver in numpy: along the path at 10 m/s, and brakes for whom it sees ahead."""

import numpy as np

SPEED, OFFSET, HEADING = 0, 3, 4
"""Columns of what is observed: speed [m/s], how far left of the path [m], heading of the path against its own [rad]."""
NEAREST = 18
"""The first of eight columns of the nearest other: seen, x, y, heading, vx, vy, length, width."""


def drive(observations: np.ndarray) -> np.ndarray:
    """Throttle, brake and steering angle of each row."""
    seen, x, y, closing = (observations[:, NEAREST + column] for column in (0, 1, 2, 4))
    ahead = (seen > 0) & (x > 0) & (np.abs(y) < 6) & (x + 2.0 * closing < 10)
    wanted = np.where(ahead, -8.0, 4.0 * (10.0 - observations[:, SPEED]))
    turn = 0.4 * np.sin(observations[:, HEADING]) - 0.04 * np.clip(observations[:, OFFSET], -1, 1)
    steer = np.clip(np.arctan(2.6 * turn), -0.5, 0.5)
    return np.stack([np.clip(wanted / 3, 0, 1), np.clip(-wanted / 8, 0, 1), steer], axis=1)
