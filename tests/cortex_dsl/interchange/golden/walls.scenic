"""Cars and a truck that slide into the buildings at the corners, after an impact or because nobody steers; and an ego
that may run into one, too.
"""

# scenario: walls.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 090d90d03a0f0267478b00647b7cf640
# risk: 11 of 22 (C 0, MD 3, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d walls.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('walls.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

class Truck(Vehicle):
    pass
class Motorcycle(Vehicle):
    pass

behavior ConstantSpeedBehavior(speed):
    while True:
        take SetSpeedAction(speed)

SPEED = 16.421313299370354  # 59.116727877733275 km/h
param SPEED = SPEED
TURN = 14.071857432450656 deg  # 14.071857432450656 deg
param TURN = TURN
OTHER = 7.164842835165174  # 25.793434206594625 km/h
param OTHER = OTHER
GRIP = 0.540019789712937
param GRIP = GRIP

behavior Straight():
    while True:
        wait

ego = new Car at (1.75, -40.0),
    facing 0.24560024406749958,
    with speed SPEED,
    with behavior Straight(),
    with friction GRIP,
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

stray = new Car at (-1.75, 40.0),
    facing 3.3871928976572923,
    with speed OTHER,
    with behavior Straight(),
    with friction GRIP,
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

one = new Car at (30.0, 1.75),
    facing 1.5707963267948966,
    with speed OTHER,
    with behavior Straight(),
    with friction GRIP,
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

two = new Truck at (5.0, 1.75),
    facing 1.0471975511965979,
    with speed 0,
    with friction GRIP,
    with width 2.44,
    with length 9.14,
    with regionContainedIn everywhere

rider = new Motorcycle at (-30.0, -1.75),
    facing -1.5707963267948966,
    with speed OTHER,
    with behavior Straight(),
    with friction GRIP,
    with width 0.8,
    with length 2.1,
    with regionContainedIn everywhere

walker = new Pedestrian at (-4.5, -4.5),
    facing 2.356194490192345,
    with speed 1,
    with behavior ConstantSpeedBehavior(1),
    with width 0.61,
    with length 0.46,
    with regionContainedIn everywhere

terminate after 8 seconds
