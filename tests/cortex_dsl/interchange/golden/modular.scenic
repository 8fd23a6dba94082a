"""Scenarios in scenarios: in turn, side by side, ended early, with actors that come in later."""

# scenario: modular.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 620925ce0608cdd389deca2104f9fdde
# risk: 8 of 22 (C 0, MD 4, D_MS 0, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d modular.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('modular.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

class Obstacle(Object):
    pass

EGO_SPEED = 14.248161750607396  # 51.29338230218662 km/h
param EGO_SPEED = EGO_SPEED
DELAY = 2.0276946537168996
param DELAY = DELAY
GAP = 14.085636314374065
param GAP = GAP

scenario Main():
    setup:
        ego = new Car at (1.75, -50.0),
            facing 0.0,
            with speed EGO_SPEED,
            with behavior FollowLaneBehavior(EGO_SPEED),
            with width 1.61,
            with length 4.508,
            with regionContainedIn everywhere
        require always ego.speed < 30
    compose:
        do Calm() for DELAY seconds
        try:
            do CutIn(GAP), Crossing()
        interrupt when ego.speed < 4:
            do Calm() for 0.5 seconds
            abort
        do Calm() for 2 seconds
        terminate

scenario Calm():
    compose:
        while True:
            wait

scenario CutIn(gap):
    box = new Obstacle at (-1.75, 30.0),
        facing -1.5707963267948966,
        with width 1.0,
        with length 1.0,
        with regionContainedIn everywhere,
        with requireVisible False
    slow = new Car at (1.75, -35.914363685625936),
        facing 0.0,
        with speed 9,
        with behavior FollowLaneBehavior(9),
        with width 1.61,
        with length 4.508,
        with regionContainedIn everywhere
    terminate when slow.position.y > -20
    terminate after 4 seconds

scenario Crossing():
    precondition: ego.speed > 7
    setup:
        other = new Car at (40.0, 1.75),
            facing 1.5707963267948966,
            with speed 9,
            with behavior FollowLaneBehavior(9),
            with width 1.61,
            with length 4.508,
            with regionContainedIn everywhere
    compose:
        do Calm() until distance from ego to other < 10
