"""Temporal requirements of every kind, and records, on two cars that cross."""

# scenario: temporal.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 602f7b284561588a283fd0b8ed858646
# risk: none, the run was aborted
# version: cortexc 0.2.0
#
# To look at it: scenic --2d temporal.scenic
#
# Not as in the original:
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('temporal.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

area_of_intersection = PolygonalRegion([(-9.5, -3.5), (-8.828213, -3.537727), (-8.164874, -3.650433), (-7.518326, -3.8367), (-6.896698, -4.094187), (-6.307808, -4.419655), (-5.759061, -4.809011), (-5.257359, -5.257359), (-4.809011, -5.759061), (-4.419655, -6.307808), (-4.094187, -6.896698), (-3.8367, -7.518326), (-3.650433, -8.164874), (-3.537727, -8.828213), (-3.5, -9.5), (3.5, -9.5), (3.537727, -8.828213), (3.650433, -8.164874), (3.8367, -7.518326), (4.094187, -6.896698), (4.419655, -6.307808), (4.809011, -5.759061), (5.257359, -5.257359), (5.759061, -4.809011), (6.307808, -4.419655), (6.896698, -4.094187), (7.518326, -3.8367), (8.164874, -3.650433), (8.828213, -3.537727), (9.5, -3.5), (9.5, 3.5), (8.828213, 3.537727), (8.164874, 3.650433), (7.518326, 3.8367), (6.896698, 4.094187), (6.307808, 4.419655), (5.759061, 4.809011), (5.257359, 5.257359), (4.809011, 5.759061), (4.419655, 6.307808), (4.094187, 6.896698), (3.8367, 7.518326), (3.650433, 8.164874), (3.537727, 8.828213), (3.5, 9.5), (-3.5, 9.5), (-3.537727, 8.828213), (-3.650433, 8.164874), (-3.8367, 7.518326), (-4.094187, 6.896698), (-4.419655, 6.307808), (-4.809011, 5.759061), (-5.257359, 5.257359), (-5.759061, 4.809011), (-6.307808, 4.419655), (-6.896698, 4.094187), (-7.518326, 3.8367), (-8.164874, 3.650433), (-8.828213, 3.537727), (-9.5, 3.5)])

EGO_SPEED = 14.248161750607396  # 51.29338230218662 km/h
param EGO_SPEED = EGO_SPEED
ADV_SPEED = 13.065535754507037  # 47.03592871622533 km/h
param ADV_SPEED = ADV_SPEED
ego = new Car at (1.75, -50.0),
    facing 0.0,
    with speed EGO_SPEED,
    with behavior FollowLaneBehavior(EGO_SPEED),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

other = new Car at (50.0, 1.75),
    facing 1.5707963267948966,
    with speed ADV_SPEED,
    with behavior FollowLaneBehavior(ADV_SPEED),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

require always distance from ego to other > 3.2 or ego.speed > 9 as "no slow closeness"
require eventually distance from ego to area_of_intersection < 1 or other.speed > 14
require ego.speed > 3 until distance from ego to area_of_intersection < 8
require next other.speed > 1
require always distance from ego to other < 12 implies next distance from ego to other < 13 as "no leap"
record distance from ego to other as "gap"
record final ego.speed
terminate after 8 seconds
