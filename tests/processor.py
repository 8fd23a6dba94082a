"""What numpy does on this processor only, and how a process runs without it."""

import os

from numpy._core import _multiarray_umath as numpy_core  # pyright: ignore[reportAttributeAccessIssue]

EXTENSIONS = tuple(name for name in numpy_core.__cpu_dispatch__ if numpy_core.__cpu_features__[name])
"""Instruction sets of this processor for which numpy has code of their own."""


def on_the_oldest() -> dict[str, str]:
    """Return the environment of a process whose numpy and OpenBLAS use the code for the oldest processors."""
    kept = {name: value for name, value in os.environ.items() if name != "UPDATE_GOLDEN"}
    return kept | {"NPY_DISABLE_CPU_FEATURES": " ".join(EXTENSIONS), "OPENBLAS_CORETYPE": "Prescott"}
