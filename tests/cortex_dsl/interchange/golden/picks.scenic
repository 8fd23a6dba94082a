"""`do choose` and `do shuffle`: chance in behaviours, guarded options."""

# scenario: picks.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 3ede8c34fa17b43db47e735a24dbdf41
# risk: 7 of 22 (C 0, MD 3, D_MS 0, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d picks.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run
# - a pedal that is set holds until it is set again, not for one step

param timestep = 0.05
param use2DMap = True
param map = localPath('picks.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model


behavior IdleBehavior():
    while True:
        wait

EGO_SPEED = 14.248161750607396  # 51.29338230218662 km/h
param EGO_SPEED = EGO_SPEED

behavior Brake(pedal):
    precondition: self.speed > 4
    take SetBrakeAction(pedal)
    take SetBrakeAction(pedal)

behavior Push(pedal):
    take SetThrottleAction(pedal)
    take SetThrottleAction(pedal)
    take SetThrottleAction(pedal)

behavior Moody():
    while True:
        do choose {Brake(0.6): 2, Push(1): 1, IdleBehavior(): 0}
        do shuffle Brake(0.9), Push(0.5), Push(0.2)

ego = new Car at (1.75, -50.0),
    facing 0.0,
    with speed EGO_SPEED,
    with behavior Moody(),
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

terminate after 10 seconds
