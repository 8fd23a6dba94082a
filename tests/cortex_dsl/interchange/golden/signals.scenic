"""Traffic lights that one car obeys and the other does not."""

# scenario: signals.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 9492336844760443968fc70302eb1a28
# risk: 6 of 22 (C 0, MD 4, D_MS 0, TTC_MS 2; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d signals.scenic
#
# Not as in the original:
# - line 6: traffic lights, which Scenic's driving library does not have: left out
# - line 9: `FollowLaneBehavior` is written without `obey_signals`, which Scenic's does not have
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('signals.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

PHASE = 7.823345575546655
param PHASE = PHASE
EGO_SPEED = 13.065535754507037  # 47.03592871622533 km/h
param EGO_SPEED = EGO_SPEED
# left out, traffic lights, which Scenic's driving library does not have:
# signals(green=3 s, yellow=1 s, offset=PHASE)
ego = new Car at (1.75, -50.0),
    facing 0.0,
    with speed EGO_SPEED,
    with behavior FollowLaneBehavior(EGO_SPEED),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

other = new Car at (50.0, 1.75),
    facing 1.5707963267948966,
    with speed 10,
    with behavior FollowLaneBehavior(10),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

terminate after 10 seconds
