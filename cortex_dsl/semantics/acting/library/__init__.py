"""The library behaviours as acts of the IR: one function each, by theme."""

from collections.abc import Callable

from cortex_dsl import ir
from cortex_dsl.semantics.acting.library import caution, following, lane_change, pedestrians, simple, yielding_way
from cortex_dsl.semantics.acting.library.job import DEFAULT_LATERAL, DEFAULT_SPEED, Inline, Job

__all__ = ["DEFAULT_LATERAL", "DEFAULT_SPEED", "Inline", "Job", "acts"]


def acts(job: Job) -> ir.Block:
    """What a library behaviour does."""
    return LIBRARY[job.call.name](job)


LIBRARY: dict[str, Callable[[Job], ir.Block]] = {
    "FollowTrajectoryBehavior": following.follow_trajectory,
    "FollowLaneBehavior": following.follow_lane,
    "CarFollowingBehavior": following.follow_car,
    "GapAcceptanceBehavior": yielding_way.accept_gap,
    "LaneChangeBehavior": lane_change.change_lane,
    "EmergencyBrakeBehavior": caution.emergency_brake,
    "DriveAvoidingCollisions": caution.drive_avoiding,
    "CrossingBehavior": pedestrians.cross,
    "WalkForwardBehavior": pedestrians.walk_forward,
    "ConstantSpeedBehavior": simple.constant_speed,
    "ConstantThrottleBehavior": simple.constant_throttle,
    "BrakeBehavior": simple.brake,
    "IdleBehavior": simple.idle,
}
