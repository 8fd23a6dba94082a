"""Monitors that count, require and end the run."""

# scenario: monitors.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 1d9364187d22ab6af06fb85ec24f6309
# risk: 5 of 22 (C 0, MD 3, D_MS 0, TTC_MS 2; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d monitors.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run
# - a pedal that is set holds until it is set again, not for one step

param timestep = 0.05
param use2DMap = True
param map = localPath('monitors.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

EGO_SPEED = 14.248161750607396  # 51.29338230218662 km/h
param EGO_SPEED = EGO_SPEED
PATIENCE = 5.731287525339432
param PATIENCE = PATIENCE

monitor Patience(limit):
    waited = 0
    while True:
        if ego.speed < 8:
            waited = waited + 1
        require distance from ego to other > 6 as "not that near"
        if waited * 0.05 > limit / 1:
            terminate
        wait

behavior Cautious():
    try:
        do FollowLaneBehavior(EGO_SPEED)
    interrupt when withinDistanceToAnyObjs(self, 25):
        require[0.9] self.speed < 16 as "calm"
        take SetBrakeAction(0.4)

ego = new Car at (1.75, -50.0),
    facing 0.0,
    with speed EGO_SPEED,
    with behavior Cautious(),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

other = new Car at (50.0, 1.75),
    facing 1.5707963267948966,
    with speed 9,
    with behavior FollowLaneBehavior(9),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

require monitor Patience(PATIENCE)
terminate after 12 seconds
