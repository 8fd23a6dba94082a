"""Lists to the arrays that programs are made of."""

import numpy as np

from engine.tables import Floats, Ints


def ints(values: object) -> Ints:
    return np.asarray(values, dtype=np.int32)


def floats(values: object) -> Floats:
    return np.asarray(values, dtype=np.float64)
