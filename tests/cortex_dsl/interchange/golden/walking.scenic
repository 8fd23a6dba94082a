"""One who walks turns at once, by what it sees of a car that turns; a driver of the simulator's own, and one whose
pedals stay as they were set, as in Scenic.
"""

# scenario: walking.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 694ad8f49015dd3f912296569a91e8ad
# risk: 12 of 22 (C 0, MD 4, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d walking.scenic
#
# Not as in the original:
# - Scenic has no `AutopilotBehavior`; its replacement lacks something: it neither gives way nor keeps its distance
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('walking.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

lane_north_in_1 = network.laneAt((-1.7499999999999982, 39.5))
lane_west_out_1 = network.laneAt((-39.5, 1.7500000000000038))
maneuver_north_in_1_to_west_out_1 = next(m for m in lane_north_in_1.maneuvers if m.endLane is lane_west_out_1)

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
    take SetWalkingDirectionAction(WAY), SetWalkingSpeedAction(1.4)
    wait for WAIT seconds
    take SetWalkingDirectionAction(roadDirection)
    wait until abs(ego.angularSpeed) > 0.1
    take SetWalkingDirectionAction(angle from self to ego), SetWalkingSpeedAction(3)
    while True:
        wait

behavior Push():
    take SetThrottleAction(0.6)
    wait for WAIT seconds
    take SetThrottleAction(0), SetBrakeAction(0.2)
    wait for 1 seconds
    do FollowLaneBehavior(6) for 1 seconds

turn = maneuver_north_in_1_to_west_out_1
way = [turn.startLane, turn.connectingLane, turn.endLane]
ego = new Car at (-1.7499999999999978, 34.5),
    facing -3.141592653589793,
    with speed SPEED,
    with behavior FollowTrajectoryBehavior(SPEED, way),
    with width 2.0,
    with length 4.5,
    with regionContainedIn everywhere

walker = new Pedestrian at (-12.34845837437831, 1.7500000000000004),
    facing 1.5707963267948966,
    with behavior Stroll(),
    with width 0.75,
    with length 0.75,
    with regionContainedIn everywhere

other = new Car at (10.956656794246776, 1.449337859092223),
    facing 1.5707963267948966,
    with speed 8,
    with behavior AutopilotBehavior(8),
    with width 2.0,
    with length 4.5,
    with regionContainedIn everywhere

last = new Car at (0.6599203963210858, 2.6955506987428803),
    facing -2.4855852479744476,
    with speed 4,
    with behavior Push(),
    with width 2.0,
    with length 4.5,
    with regionContainedIn everywhere

record ego.angularSpeed as "turning"
record walker.heading as "way"
terminate after 9 seconds
