"""Eight of all kinds on a slippery road: others strike one another, slide, and strike again before the ego comes."""

# scenario: pile.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 0a5e5603c663eff5670f94628e9d69b7
# risk: 22 of 22 (C 10, MD 4, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d pile.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('pile.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

class Bicycle(Vehicle):
    pass
class Truck(Vehicle):
    pass
class Bus(Vehicle):
    pass
class Motorcycle(Vehicle):
    pass
class Obstacle(Object):
    pass

behavior ConstantSpeedBehavior(speed):
    while True:
        take SetSpeedAction(speed)

SPEED = 17.025939528385173  # 61.29338230218662 km/h
param SPEED = SPEED
OTHERS = 13.065535754507037  # 47.03592871622533 km/h
param OTHERS = OTHERS
GRIP = 0.23476060523956777
param GRIP = GRIP
GAP = 7.233696144737176
param GAP = GAP

behavior Blind(target):
    do FollowLaneBehavior(target)

ego = new Car at (1.75, -85.0),
    facing 0.0,
    with speed SPEED,
    with behavior Blind(SPEED),
    with friction GRIP,
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

one = new Car at (1.75, -62.76630385526283),
    facing 0.0,
    with speed OTHERS,
    with behavior Blind(OTHERS),
    with friction GRIP,
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

two = new Bicycle at (1.75, -52.76630385526283),
    facing 0.0,
    with speed 3,
    with behavior Blind(3),
    with friction GRIP,
    with width 0.6,
    with length 1.8,
    with regionContainedIn everywhere

three = new Truck at (1.75, -32.76630385526283),
    facing 0.0872664625997166,
    with speed 0,
    with friction GRIP,
    with width 2.44,
    with length 9.14,
    with regionContainedIn everywhere

four = new Bus at (-60.0, -1.75),
    facing -1.5707963267948966,
    with speed OTHERS,
    with behavior Blind(OTHERS),
    with friction GRIP,
    with width 2.59,
    with length 12.2,
    with regionContainedIn everywhere

five = new Motorcycle at (60.0, 1.75),
    facing 1.5707963267948966,
    with speed OTHERS,
    with behavior Blind(OTHERS),
    with friction GRIP,
    with width 0.8,
    with length 2.1,
    with regionContainedIn everywhere

walker = new Pedestrian at (3.0, -20.0),
    facing 1.5707963267948966,
    with speed 1,
    with behavior ConstantSpeedBehavior(1),
    with width 0.61,
    with length 0.46,
    with regionContainedIn everywhere

crate = new Obstacle at (1.0, -15.0),
    facing -1.5707963267948966,
    with friction GRIP,
    with width 1.0,
    with length 1.0,
    with regionContainedIn everywhere,
    with requireVisible False

terminate after 10 seconds
