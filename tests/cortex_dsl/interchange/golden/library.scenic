"""Library behaviours that look at others, on a wide road, with noise on the start."""

# scenario: library.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: e560610c4e2aaf5386e687fe8641f4a8
# risk: 12 of 22 (C 0, MD 4, D_MS 4, TTC_MS 4; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d library.scenic
#
# Not as in the original:
# - Scenic has no `CarFollowingBehavior`; its replacement lacks something: it keeps its speed, even behind other actors
# - line 18: Scenic has no `before … by`: left out
# - Scenic has no `EmergencyBrakeBehavior`; its replacement lacks something: it drives as the behavior that it is given, without an emergency brake
# - line 20: `EmergencyBrakeBehavior` is written without `foresees`, which Scenic's does not have
# - Scenic has no `GapAcceptanceBehavior`; its replacement lacks something: it never gives way
# - Scenic has no `CrossingBehavior`; its replacement lacks something: it walks at its least speed, and does not time its arrival
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run

param timestep = 0.05
param use2DMap = True
param map = localPath('library.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

lane_west_in_2 = network.laneAt((-53.0, -1.75))
lane_north_out_2 = network.laneAt((1.7500000000000024, 53.0))
maneuver_west_in_2_to_north_out_2 = next(m for m in lane_west_in_2.maneuvers if m.endLane is lane_north_out_2)
section_west_in_1 = network.laneSectionAt((-53.0, -5.25))

behavior CarFollowingBehavior(target_speed=10, trajectory=None):
    # in its place: it keeps its speed, even behind other actors
    if trajectory is None:
        do FollowLaneBehavior(target_speed=target_speed)
    else:
        do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)

behavior EmergencyBrakeBehavior(behavior):
    # in its place: it drives as the behavior that it is given, without an emergency brake
    do behavior

behavior GapAcceptanceBehavior(target_speed=10, trajectory=None):
    # in its place: it never gives way
    do FollowTrajectoryBehavior(target_speed=target_speed, trajectory=trajectory)

behavior CrossingBehavior(reference_actor, min_speed=1, threshold=10):
    # in its place: it walks at its least speed, and does not time its arrival
    while (distance from self to reference_actor) > threshold:
        wait
    while True:
        take SetWalkingDirectionAction(self.heading), SetWalkingSpeedAction(min_speed)

EGO_SPEED = 14.248161750607396  # 51.29338230218662 km/h
param EGO_SPEED = EGO_SPEED
LEAD_SPEED = 7.960121562971434  # 28.656437626697162 km/h
param LEAD_SPEED = LEAD_SPEED

class Van(Car):
    width: 2.1
    length: 5.5

inner = lane_west_in_2
turn = maneuver_west_in_2_to_north_out_2

behavior Evade(speed):
    do LaneChangeBehavior(section_west_in_1, target_speed=speed)
    do CarFollowingBehavior(speed)

# left out, Scenic has no `before … by`:
# lead = new OrientedPoint before intersection by 35 m along [inner]
ego = new Car at (-75.254, -1.75),
    facing -1.5707963267948966,
    with speed EGO_SPEED,
    with behavior EmergencyBrakeBehavior(Evade(EGO_SPEED)),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

van = new Van at (-47.59299289754172, -1.672372233823864),
    facing -1.5600748942152598,
    with speed LEAD_SPEED,
    with behavior GapAcceptanceBehavior(LEAD_SPEED, [inner, turn.connectingLane, turn.endLane]),
    with width 2.1,
    with length 5.5,
    with regionContainedIn everywhere

cross = new Car at (-32.84075526070625, -0.5626622992702082),
    facing -1.5707963267948966,
    with speed 9,
    with behavior DriveAvoidingCollisions(9),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

walker = new Pedestrian at (71.51471827010567, 6.224247026441748),
    facing 1.5707963267948966,
    with behavior CrossingBehavior(ego, 1.5, 20),
    with width 0.61,
    with length 0.46,
    with regionContainedIn everywhere

terminate after 9 seconds
