"""People who turn at once, one of them by what it sees of a car that turns; a driver of the simulator's own."""

# scenario: walking.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: fec8bd065fbfcdf396596193b4454a43
# risk: 22 of 22 (C 10, MD 4, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d walking.scenic
#
# Not as in the original:
# - Scenic has no `AutopilotBehavior`; what stands in for it lacks something: it neither gives way nor keeps its distance
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('walking.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

lane_west_in_1 = network.laneAt((-39.5, -1.75))
lane_south_out_1 = network.laneAt((-1.7499999999999982, -39.5))
maneuver_west_in_1_to_south_out_1 = next(m for m in lane_west_in_1.maneuvers if m.endLane is lane_south_out_1)

behavior AutopilotBehavior(target_speed=10, trajectory=None):
    # in its place: it neither gives way nor keeps its distance
    if trajectory is None:
        do FollowLaneBehavior(target_speed=target_speed)
    else:
        do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)

SPEED = 11.772697087337027  # 42.381709514413295 km/h
param SPEED = SPEED
WAIT = 2.0276946537168996
param WAIT = WAIT
WAY = 41.71272628748132 deg  # 41.71272628748132 deg
param WAY = WAY

behavior Stroll():
    take SetWalkingDirectionAction(WAY - 90 deg), SetWalkingSpeedAction(1.4)
    wait for WAIT
    take SetWalkingDirectionAction(roadDirection)
    wait until abs(ego.angularSpeed) > 0.1
    take SetWalkingDirectionAction((angle from self to ego) - 90 deg), SetWalkingSpeedAction(3)
    while True:
        wait

turn = maneuver_west_in_1_to_south_out_1
way = [turn.startLane, turn.connectingLane, turn.endLane]
ego = new Car at (-34.5, -1.75),
    facing -1.5707963267948966,
    with speed SPEED,
    with behavior FollowTrajectoryBehavior(SPEED, way),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

walker = new Pedestrian at (-1.7499999999999998, -13.746915659151455),
    facing -3.141592653589793,
    with behavior Stroll(),
    with width 0.61,
    with length 0.46,
    with regionContainedIn everywhere

other = new Car at (48.380383794413554, 2.528130440601543),
    facing 1.5707963267948966,
    with speed 8,
    with behavior AutopilotBehavior(8),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

record ego.angularSpeed as "turning"
record walker.heading + 90 deg as "way"
terminate after 9 seconds
