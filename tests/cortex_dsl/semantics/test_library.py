"""Numbers that the library shares with the engine: the compiler cannot import kernels, so it has its own copies."""

from cortex_dsl.semantics.acting.library import job, lane_change
from engine.kernels import steering


def test_the_speed_controller_is_the_engines() -> None:
    """Gain, planned deceleration, preview, and the limit of what is asked for."""
    assert steering.SPEED_GAIN == job.SPEED_GAIN
    assert steering.PLANNED_BRAKING == job.STOPPING
    assert steering.SPEED_PREVIEW == job.STOP_PREVIEW
    assert steering.MAX_BRAKING == lane_change.BRAKING_LIMIT


def test_the_steering_law_is_the_engines() -> None:
    """Preview, look-ahead, and the share of it above which offsets are clipped."""
    assert steering.PREVIEW == lane_change.PREVIEW
    assert steering.LOOK_AHEAD == lane_change.LOOK_AHEAD
    assert steering.MIN_LOOK_AHEAD == lane_change.MIN_LOOK_AHEAD
    assert steering.OFFSET_SHARE == lane_change.OFFSET_SHARE
