"""What is held against one another of scenes that were sampled here and by Scenic; needs numpy alone."""

from collections.abc import Mapping
from itertools import combinations

import numpy as np


def quantities(scenes: np.ndarray) -> Mapping[str, np.ndarray]:
    """By name, one number a scene; `scenes` are (n, objects, 3): x, y [m], heading [rad, anticlockwise from +x]."""
    found: dict[str, np.ndarray] = {}
    for number in range(scenes.shape[1]):
        x, y, heading = scenes[:, number].T
        of_each = {"x": x, "y": y, "cosine of heading": np.cos(heading), "sine of heading": np.sin(heading)}
        found |= {f"{name} of object {number}": values for name, values in of_each.items()}
    for one, other in combinations(range(scenes.shape[1]), 2):
        found[f"distance of {one} and {other}"] = np.hypot(*(scenes[:, one, :2] - scenes[:, other, :2]).T)
    return found
