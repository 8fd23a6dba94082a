"""Three cars in a column: the first brakes, the second often strikes it, and the ego behind sees nothing but the second."""

# scenario: column.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: e6a0773c91f247d54fc96a66bbf52dea
# risk: 22 of 22 (C 10, MD 4, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d column.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run
# - a pedal that is set holds until it is set again, not for one step

param timestep = 0.05
param use2DMap = True
param map = localPath('column.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

SPEED = 19.803717306162948  # 71.29338230218661 km/h
param SPEED = SPEED
GAP = 27.545659011829564
param GAP = GAP
HEADWAY = 7.896717103297314
param HEADWAY = HEADWAY
BRAKE = 0.7833498247607807
param BRAKE = BRAKE
REACTION = 1.6022033533871005
param REACTION = REACTION

behavior Stop():
    do FollowLaneBehavior(SPEED) for 1 seconds
    while True:
        take SetBrakeAction(BRAKE)

behavior Late(reaction):
    """Notices that somebody brakes after a while, and brakes then."""
    do FollowLaneBehavior(SPEED) for 1 seconds
    do FollowLaneBehavior(SPEED) for reaction seconds
    while True:
        take SetBrakeAction(0.8)

ego = new Car at (1.75, -190.0),
    facing 0.0,
    with speed SPEED,
    with behavior Late(2 * REACTION),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

middle = new Car at (1.75, -177.5032828967027),
    facing 0.0,
    with speed SPEED,
    with behavior Late(REACTION),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

first = new Car at (1.75, -145.35762388487314),
    facing 0.0,
    with speed SPEED,
    with behavior Stop(),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

terminate after 12 seconds
