"""Expectations and numbers of the run: formulas of every operator, contact included, reducers and results by name."""

# scenario: objectives.scn
# seed: 1
# stream: 1.sample.0.0.0.0
# digest: 09ec3b598b3f181c36c93dbce41a3fc1
# risk: 20 of 22 (C 10, MD 4, D_MS 4, TTC_MS 2; profile paper)
# version: cortexc 0.2.0
#
# To look at it: scenic --2d objectives.scenic
#
# Not as in the original:
# - line 17: Scenic has no `expect`: left out
# - line 18: Scenic has no `expect`: left out
# - line 19: Scenic has no `expect`: left out
# - line 20: Scenic has no `expect`: left out
# - line 21: Scenic has no `expect`: left out
# - line 22: Scenic has no `expect`: left out
# - line 23: Scenic has neither `maximize` nor `minimize`: left out
# - line 24: Scenic has neither `maximize` nor `minimize`: left out
# - line 25: Scenic has neither `maximize` nor `minimize`: left out
# - line 26: Scenic has neither `maximize` nor `minimize`: left out
# - line 27: Scenic has neither `maximize` nor `minimize`: left out
# - line 28: Scenic has neither `maximize` nor `minimize`: left out
# - the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run
# - a pedal that is set holds until it is set again, not for one step

param timestep = 0.05
param use2DMap = True
param map = localPath('objectives.xodr')
# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:
# `model scenic.simulators.metadrive.model`.
model scenic.domains.driving.model

lane_north_in_1 = network.laneAt((-1.7499999999999984, 34.5))
lane_south_out_1 = network.laneAt((-1.7499999999999984, -34.5))
maneuver_north_in_1_to_south_out_1 = next(m for m in lane_north_in_1.maneuvers if m.endLane is lane_south_out_1)
class Truck(Vehicle):
    pass

behavior ConstantSpeedBehavior(speed):
    while True:
        take SetSpeedAction(speed)

GAP = 32.16404407196796
param GAP = GAP
V = 10.110778614867598
param V = V
PEDAL = 0.06952121047913552
param PEDAL = PEDAL
way = [lane_north_in_1]
maneuver = maneuver_north_in_1_to_south_out_1
whole = [maneuver.startLane, maneuver.connectingLane, maneuver.endLane]

behavior Careful():
    try:
        do FollowTrajectoryBehavior(V, whole)
    interrupt when distance to truck < 9:
        take SetBrakeAction(PEDAL)

ego = new Car at (-1.7499999999999998, 54.5),
    facing -3.141592653589793,
    with speed V,
    with behavior Careful(),
    with width 1.61,
    with length 4.508,
    with regionContainedIn everywhere

truck = new Truck at (-1.7499999999999973, 15.511955928032044),
    facing -3.141592653589793,
    with speed 2,
    with behavior ConstantSpeedBehavior(2),
    with width 2.44,
    with length 9.14,
    with regionContainedIn everywhere

# left out, Scenic has no `expect`:
# expect always (minimum distance from ego to truck) > 0 m as "room"
# left out, Scenic has no `expect`:
# expect always not self.collided as "no contact"
# left out, Scenic has no `expect`:
# expect (eventually ego.speed < 2 m/s) or (always ego.speed > 1 m/s) as "steady"
# left out, Scenic has no `expect`:
# expect (ego.speed > 1 m/s until (distance to truck) < 9 m) implies (next ego in road) as "until"
# left out, Scenic has no `expect`:
# expect always (ego.position in road and ego can see truck) as "on the road"
# left out, Scenic has no `expect`:
# expect always relative heading of ego from truck < 20 deg as "turned"
# left out, Scenic has neither `maximize` nor `minimize`:
# maximize largest(ego.speed) - least(ego.speed) as "spread"
# left out, Scenic has neither `maximize` nor `minimize`:
# minimize mean(distance to truck) + 1 s * final(ego.speed) as "near"
# left out, Scenic has neither `maximize` nor `minimize`:
# maximize total(1 if ego.speed > 3 m/s else 0) as "fast for"
# left out, Scenic has neither `maximize` nor `minimize`:
# maximize delta_v as "delta-V"
# left out, Scenic has neither `maximize` nor `minimize`:
# minimize post_encroachment_time as "PET"
# left out, Scenic has neither `maximize` nor `minimize`:
# minimize min_distance + 1 s * closing_speed as "close"
terminate after 7 seconds
