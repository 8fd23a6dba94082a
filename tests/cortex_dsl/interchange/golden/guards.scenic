"""Preconditions and invariants, tested when a behaviour goes on by itself."""

# scenario: guards.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 7838a37f1c8ba7f4af6a95b63e876d30
# risk: none, the run was aborted
# version: cortexc 0.2.0
#
# To look at it: scenic --2d guards.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run
# - a pedal that is set holds until it is set again, not for one step

param timestep = 0.05
param use2DMap = True
param map = localPath('guards.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

EGO_SPEED = 16.421313299370354  # 59.116727877733275 km/h
param EGO_SPEED = EGO_SPEED
LIMIT = 16.1107786148676
param LIMIT = LIMIT

behavior Hurry(limit):
    precondition: self.speed < 18
    invariant: self.speed < limit
    for_now = 0
    while for_now < 6:
        for_now = for_now + 1
        take SetThrottleAction(0.8)
    do FollowLaneBehavior(EGO_SPEED) for 2 seconds
    take SetThrottleAction(0.5)
    do FollowLaneBehavior(EGO_SPEED)

ego = new Car at (1.75, -50.0),
    facing 0.0,
    with speed EGO_SPEED,
    with behavior Hurry(LIMIT),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

other = new Car at (50.0, 1.75),
    facing 1.5707963267948966,
    with speed EGO_SPEED,
    with behavior FollowLaneBehavior(EGO_SPEED),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

terminate after 8 seconds
