"""Hypothesis searches anew on every run of a developer and repeats itself in CI; a slow example is no failure.

What can be made again (parser tables, compiled kernels, proofs, lists of fonts) is kept in `build/cache` of the
checkout, so that no test depends on what lies in the user's cache, and none leaves anything there.
"""

import os
from pathlib import Path

from hypothesis import HealthCheck, settings

from engine.user_cache import ENVIRONMENT_VARIABLE

CACHE = Path(__file__).parent.parent / "build" / "cache"
os.environ.setdefault(ENVIRONMENT_VARIABLE, str(CACHE))
os.environ.setdefault("MPLCONFIGDIR", str(CACHE / "matplotlib"))
settings.register_profile("everywhere", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("everywhere"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "everywhere")
