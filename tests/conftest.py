"""Hypothesis searches anew on every run of a developer and repeats itself in CI; a slow example is no failure.

What can be made again (parser tables, compiled kernels, proofs, lists of fonts) is kept in `build/cache` of the
checkout, so that no test depends on what lies in the user's cache, and none leaves anything there.

A shell that runs the suite in the background has it ignore Ctrl-C, and `nohup` the end of a session: every process that
a test starts would too.
"""

import os
import signal
from pathlib import Path

from hypothesis import HealthCheck, settings

from engine.user_cache import ENVIRONMENT_VARIABLE

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if hasattr(signal, "SIGHUP") and signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
CACHE = Path(__file__).parent.parent / "build" / "cache"
os.environ.setdefault(ENVIRONMENT_VARIABLE, str(CACHE))
os.environ.setdefault("MPLCONFIGDIR", str(CACHE / "matplotlib"))
settings.register_profile("everywhere", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("everywhere"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "everywhere")
