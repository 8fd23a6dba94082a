"""A naive driver in numpy: 10 m/s along the path, with full braking for a car in its lane or about to enter it.

Its weakness: it foresees half a second only. By then, a car from the side is often nearer than the braking distance.
"""

import numpy as np

SPEED, OFFSET, HEADING = 0, 3, 4
"""Columns of what is observed: speed [m/s], how far left of the path [m], heading of the path against its own [rad]."""
NEAREST = 18
"""The first of eight columns of the nearest other: seen, x, y, heading, vx, vy, length, width."""
FORESIGHT = 0.5
"""Time for which it foresees the motion of others, straight on [s]."""


def drive(observations: np.ndarray) -> np.ndarray:
    """Throttle, brake and steering angle of each row."""
    seen, x, y, drift = (observations[:, NEAREST + column] for column in (0, 1, 2, 5))
    soon = y + FORESIGHT * drift
    in_lane = (np.minimum(y, soon) < 2) & (np.maximum(y, soon) > -2)
    brakes = (seen > 0) & (x > 0) & (x < 15) & in_lane
    wanted = np.where(brakes, -8.0, 4.0 * (10.0 - observations[:, SPEED]))
    steer = np.clip(observations[:, HEADING] - 0.1 * np.clip(observations[:, OFFSET], -1, 1), -0.5, 0.5)
    return np.stack([np.clip(wanted / 3, 0, 1), np.clip(-wanted / 8, 0, 1), steer], axis=1)
