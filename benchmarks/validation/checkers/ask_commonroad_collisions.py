"""CommonRoad's drivability checker: does it see our first contact when we do? It needs an older commonroad-io."""

import math

from answering import answer
from commonroad.common.file_reader import CommonRoadFileReader
from commonroad.common.solution import CommonRoadSolutionReader
from commonroad.geometry.shape import Rectangle
from commonroad.prediction.prediction import TrajectoryPrediction
from commonroad_dc import pycrcc
from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import create_collision_object
from commonroad_dc.feasibility.solution_checker import goal_reached, solved_all_problems, starts_at_correct_state


def check(job: dict) -> list[str]:
    """Scenario and solution belong together, and the ego is hit in the step in which ours is, or the next."""
    scenario, problems = CommonRoadFileReader(job["file"]).open(lanelet_assignment=True)
    solution = CommonRoadSolutionReader.open(job["file"].replace(".cr.xml", ".solution.xml"))
    found = [] if str(solution.scenario_id) == str(scenario.scenario_id) else ["benchmark ids differ"]
    solved_all_problems(problems, solution)
    starts_at_correct_state(solution, problems)
    goal_reached(scenario, problems, solution)
    return found + compare(first_collision(scenario, solution, job["size"]), job)


def first_collision(scenario: object, solution: object, size: list[float]) -> int | None:
    """The first step at which the ego, in its own size, overlaps somebody, or a building. What the checker makes of a
    scenario by itself leaves obstacles of the environment out, which have a shape and no states.
    """
    trajectory = solution.planning_problem_solutions[0].trajectory
    ego = create_collision_object(TrajectoryPrediction(trajectory, Rectangle(*size)))
    walls = [each.obstacle_shape for each in scenario.environment_obstacle]
    bodies = [*scenario.static_obstacles, *scenario.dynamic_obstacles, *walls]
    others = [create_collision_object(each) for each in bodies]
    for step in range(len(trajectory.state_list)):
        checker = pycrcc.CollisionChecker()
        for other in others:
            moves = isinstance(other, pycrcc.TimeVariantCollisionObject)
            there = other.obstacle_at_time(step) if moves else other
            if there is not None:
                checker.add_collision_object(there)
        if checker.collide(ego.obstacle_at_time(step)):
            return step
    return None


def compare(step: int | None, job: dict) -> list[str]:
    """Against our contact, if the ego takes part in it."""
    contact = job["contact"]
    expected = contact["time"] - job["begins"] if contact and 0 in contact["actors"] else None
    if (step is None) != (expected is None):
        return [f"the ego is hit at step {step} there, at {expected} s here"]
    off = 0.0 if expected is None else abs(step - expected / job["step"])
    return [f"the ego is hit {off:.3f} steps apart"] if off > 1.0 or not math.isfinite(off) else []


answer(check)
