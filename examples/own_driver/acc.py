"""An adaptive cruise control in numpy: it keeps a time gap to the vehicle ahead in its lane.

Its weaknesses: it brakes no harder than 3.5 m/s^2, as cruise controls do, and a vehicle that moves over counts only
when its middle is within 1.2 m of the middle of the lane.
"""

import numpy as np

SPEED, OFFSET, HEADING = 0, 3, 4
"""Columns of what is observed: speed [m/s], how far left of the path [m], heading of the path against its own [rad]."""
NEAREST, EACH = 18, 8
"""The first column of the nearest others, and the columns of each: seen, x, y, heading, vx, vy, length, width."""
SET_SPEED = 33.0
"""[m/s]"""
TIME_GAP, STANDSTILL_GAP = 0.7, 3.0
"""Gap to keep: for each m/s of its speed [s], and at rest [m]."""
HARDEST, LANE = 3.5, 1.2
"""Greatest deceleration [m/s^2], and how far beside its middle a vehicle is in its lane [m]."""
BRAKE, THROTTLE = 8.0, 3.0
"""Deceleration at full brake and acceleration at full throttle [m/s^2]."""


def drive(observations: np.ndarray) -> np.ndarray:
    """Throttle, brake and steering angle of each row."""
    speed, heading = observations[:, SPEED], observations[:, HEADING]
    others = observations[:, NEAREST:].reshape(len(observations), -1, EACH)
    seen, x, y, faster, length = (others[:, :, column] for column in (0, 1, 2, 4, 6))
    gap = np.where((seen > 0) & (x > 0) & (np.abs(y) < LANE), x - 0.5 * length - 2.3, np.inf)
    lead = gap.argmin(axis=1)
    rows = np.arange(len(gap))
    gap, closing = gap[rows, lead], faster[rows, lead]
    follow = 0.3 * (np.minimum(gap, 1e3) - STANDSTILL_GAP - TIME_GAP * speed) + 0.9 * np.where(gap < 1e3, closing, 0.0)
    wanted = np.clip(np.minimum(0.5 * (SET_SPEED - speed), follow), -HARDEST, 2.0)
    steer = np.clip(heading - 0.05 * np.clip(observations[:, OFFSET], -1, 1), -0.3, 0.3)
    return np.stack([np.clip(wanted / THROTTLE, 0, 1), np.clip(-wanted / BRAKE, 0, 1), steer], axis=1)
