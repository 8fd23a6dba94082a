"""CommonRoad: a scenario for planners (`<stem>.cr.xml`), and the ego's motion as its solution (`<stem>.solution.xml`).

Format: XML 2020a, Althoff et al., "CommonRoad: Composable benchmarks for motion planning on roads", IV 2017, with its
published schema; names of vehicles, models and costs as commonroad-io reads them.
"""

from engine.interchange.commonroad.write import write_commonroad

__all__ = ["write_commonroad"]
