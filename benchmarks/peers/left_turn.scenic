"""An oncoming car turns left across the path of the ego, which brakes for whatever is near."""

param map = localPath('crossing.xodr')
param use2DMap = True
param render = False
model scenic.simulators.newtonian.driving_model

EGO_SPEED = Range(5, 15)
ADV_SPEED = Range(5, 15)
EGO_INIT_DIST = Range(10, 40)
ADV_INIT_DIST = Range(10, 40)

behavior EgoBehavior(trajectory):
    try:
        do FollowTrajectoryBehavior(target_speed=EGO_SPEED, trajectory=trajectory)
    interrupt when withinDistanceToAnyObjs(self, 10):
        take SetBrakeAction(1)

intersection = Uniform(*network.intersections)
egoInitLane = Uniform(*intersection.incomingLanes)
egoManeuver = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, egoInitLane.maneuvers))
egoTrajectory = [egoInitLane, egoManeuver.connectingLane, egoManeuver.endLane]
egoSpawnPt = new OrientedPoint in egoInitLane.centerline

advInitLane = Uniform(*egoManeuver.reverseManeuvers).startLane
advManeuver = Uniform(*filter(lambda m: m.type is ManeuverType.LEFT_TURN, advInitLane.maneuvers))
advTrajectory = [advInitLane, advManeuver.connectingLane, advManeuver.endLane]
advSpawnPt = new OrientedPoint in advInitLane.centerline

ego = new Car at egoSpawnPt, with behavior EgoBehavior(egoTrajectory)
adversary = new Car at advSpawnPt, with behavior FollowTrajectoryBehavior(target_speed=ADV_SPEED, trajectory=advTrajectory)

require abs((distance from ego to intersection) - EGO_INIT_DIST) <= 2.5
require abs((distance from adversary to intersection) - ADV_INIT_DIST) <= 2.5
terminate when (distance from ego to egoSpawnPt) > 70
terminate after 20 seconds
