"""CommonRoad's reader: scenario, lanelets, planning problem and solution, without a word of complaint."""

from answering import answer
from commonroad.common.file_reader import CommonRoadFileReader
from commonroad.common.solution import CommonRoadSolutionReader


def check(job: dict) -> list[str]:
    """Everything can be read and belongs together; obstacles find their lanelets, bounds do not cross themselves."""
    scenario, problems = CommonRoadFileReader(job["file"]).open(lanelet_assignment=True)
    solution = CommonRoadSolutionReader.open(job["file"].replace(".cr.xml", ".solution.xml"))
    found = [] if str(solution.scenario_id) == str(scenario.scenario_id) else ["benchmark ids differ"]
    if set(solution.planning_problem_ids) != set(problems.planning_problem_dict):
        found.append("the solution is one of other problems")
    walls = [each.obstacle_type.value for each in scenario.environment_obstacle]
    if walls != ["building"] * job["buildings"]:
        found.append(f"{len(walls)} obstacles of the environment, not {job['buildings']} buildings")
    if len(scenario.obstacles) != job["movers"] - 1 + len(walls):
        found.append(f"{len(scenario.obstacles) - len(walls)} obstacles, not {job['movers'] - 1}")
    crossed = [each for each in scenario.lanelet_network.lanelets if not each.polygon.shapely_object.is_valid]
    return found + [f"lanelet {each.lanelet_id} crosses itself" for each in crossed]


OWN_WORDS = r".*: successor(Right|Straight|Left) \d+ is of deprecated format, thus mapped to outgoing\1"
"""Said of the only words that the schema of 2020a has for it, of which this reader's package brings a copy."""
answer(check, known=OWN_WORDS)
