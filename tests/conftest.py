"""Hypothesis searches anew on every run of a developer and repeats itself in CI. No test depends on speed.

A deadline, and the check that examples are drawn quickly, measure the clock of a machine that may do other work.
"""

import os

from hypothesis import HealthCheck, settings

settings.register_profile("suite", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", settings.get_profile("suite"), derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "suite")
