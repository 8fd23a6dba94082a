"""Numbers that the library shares with the engine: the compiler cannot import kernels, so it has its own copies."""

from cortex_dsl.semantics.acting import following, job
from engine.kernels import steering


def test_the_speed_controller_is_the_engines() -> None:
    """Gain, planned deceleration, preview, and the limit of what is asked for."""
    assert steering.SPEED_GAIN == job.SPEED_GAIN
    assert steering.PLANNED_BRAKING == job.STOPPING
    assert steering.SPEED_PREVIEW == job.STOP_PREVIEW
    assert steering.MAX_BRAKING == following.BRAKING_LIMIT


def test_the_steering_law_is_the_engines() -> None:
    """Preview, look-ahead, and the share of it above which offsets are clipped."""
    assert steering.PREVIEW == following.PREVIEW
    assert steering.LOOK_AHEAD == following.LOOK_AHEAD
    assert steering.MIN_LOOK_AHEAD == following.MIN_LOOK_AHEAD
    assert steering.OFFSET_SHARE == following.OFFSET_SHARE
