"""Small files of our own making, written from a few words, and how they are read."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from engine.interchange import InterchangeError
from engine.interchange.openscenario.read import Imported, read_openscenario
from engine.opendrive.read import read_opendrive
from engine.opendrive.roads import OdrNetwork

TIMING = '<Timing domainAbsoluteRelative="absolute" offset="0" scale="1"/>'
ROAD = '<RoadNetwork><LogicFile filepath="road.xodr"/></RoadNetwork>'
NO_ROAD = "<RoadNetwork/>"

XODR = """<?xml version="1.0"?>
<OpenDRIVE><header revMajor="1" revMinor="7"/>
<road id="1" length="100" junction="-1" name="main">
 <planView><geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry></planView>
 <lanes><laneSection s="0">
  <left><lane id="1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane></left>
  <center><lane id="0" type="none"/></center>
  <right>
   <lane id="-1" type="driving"><width sOffset="0" a="3" b="0" c="0" d="0"/></lane>
   <lane id="-2" type="driving"><width sOffset="0" a="4" b="0" c="0" d="0"/></lane>
  </right>
 </laneSection></lanes>
</road></OpenDRIVE>
"""


def world(x: float, y: float = 0.0, h: float | None = None) -> str:
    heading = "" if h is None else f' h="{h!r}"'
    return f'<Position><WorldPosition x="{x!r}" y="{y!r}"{heading}/></Position>'


def vehicle(name: str, *, center: float = 1.5, properties: str = "") -> str:
    return f"""<ScenarioObject name="{name}"><Vehicle name="{name}" vehicleCategory="car">
  <BoundingBox><Center x="{center}" y="0" z="0.7"/><Dimensions width="1.8" length="4.5" height="1.5"/></BoundingBox>
  <Performance maxSpeed="70" maxAcceleration="5" maxDeceleration="9"/>
  <Axles><FrontAxle maxSteering="0.5" wheelDiameter="0.6" trackWidth="1.6" positionX="2.7" positionZ="0.3"/>
  <RearAxle maxSteering="0" wheelDiameter="0.6" trackWidth="1.6" positionX="0" positionZ="0.3"/></Axles>
  <Properties>{properties}</Properties></Vehicle></ScenarioObject>"""


def polyline(*vertices: tuple[float | None, str]) -> str:
    times = ["" if time is None else f' time="{time!r}"' for time, _ in vertices]
    rows = (f"<Vertex{time}>{place}</Vertex>" for time, (_, place) in zip(times, vertices, strict=True))
    return f"<Polyline>{''.join(rows)}</Polyline>"


def follow(shape: str, timing: str = TIMING, *, first: bool = False) -> str:
    """The action; `first` places the trajectory as version 1.0 does."""
    trajectory = f'<Trajectory name="way" closed="false"><Shape>{shape}</Shape></Trajectory>'
    holder = trajectory if first else f"<TrajectoryRef>{trajectory}</TrajectoryRef>"
    return (
        f"<PrivateAction><RoutingAction><FollowTrajectoryAction>{holder}<TimeReference>{timing}</TimeReference>"
        '<TrajectoryFollowingMode followingMode="position"/></FollowTrajectoryAction></RoutingAction></PrivateAction>'
    )


def teleport(place: str) -> str:
    return f"<PrivateAction><TeleportAction>{place}</TeleportAction></PrivateAction>"


def speed(value: float) -> str:
    return (
        '<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionDynamics dynamicsShape="step" value="0" '
        'dynamicsDimension="time"/><SpeedActionTarget><AbsoluteTargetSpeed value="'
        f'{value}"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>'
    )


def at_time(value: float, rule: str = "greaterOrEqual", delay: float = 0.0) -> str:
    return (
        f'<ConditionGroup><Condition name="c" delay="{delay}" conditionEdge="none"><ByValueCondition>'
        f'<SimulationTimeCondition value="{value}" rule="{rule}"/></ByValueCondition></Condition></ConditionGroup>'
    )


def event(entity: str, action: str, start: str = "") -> str:
    return (
        f'<ManeuverGroup name="g" maximumExecutionCount="1"><Actors selectTriggeringEntities="false">'
        f'<EntityRef entityRef="{entity}"/></Actors><Maneuver name="m"><Event name="e" priority="override">'
        f'<Action name="a">{action}</Action><StartTrigger>{start}</StartTrigger></Event></Maneuver></ManeuverGroup>'
    )


def scenario(
    entities: Sequence[str],
    init: Sequence[tuple[str, str]] = (),
    events: Sequence[str] = (),
    *,
    network: str = NO_ROAD,
    parameters: str = "",
    stop: str = "",
    catalogs: str = "",
    minor: int = 2,
) -> str:
    """The text of a scenario; `init` holds pairs of an entity and its actions."""
    private = "".join(f'<Private entityRef="{name}">{actions}</Private>' for name, actions in init)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<OpenSCENARIO><FileHeader revMajor="1" revMinor="{minor}" date="2026-01-01T00:00:00" description="d" author="a"/>
<ParameterDeclarations>{parameters}</ParameterDeclarations><CatalogLocations>{catalogs}</CatalogLocations>
{network}
<Entities>{"".join(entities)}</Entities>
<Storyboard><Init><Actions>{private}</Actions></Init>
<Story name="s"><Act name="act">{"".join(events)}<StartTrigger>{at_time(0)}</StartTrigger></Act></Story>
<StopTrigger>{stop}</StopTrigger></Storyboard></OpenSCENARIO>
"""


STRAIGHT = polyline((0.0, world(0.0, 0.0, 0.0)), (0.1, world(1.0, 0.0, 0.0)), (0.2, world(2.0, 0.0, 0.0)))


def simple(shape: str = STRAIGHT, timing: str = TIMING, network: str = NO_ROAD) -> str:
    """One car, `Ego`, that follows a shape from the beginning."""
    return scenario([vehicle("Ego")], [("Ego", follow(shape, timing))], network=network)


def read(folder: Path, text: str | bytes, road: str | None = None, **options: Any) -> Imported:
    """What the reader makes of a text, with a road beside it if there is one."""
    (folder / "case.xosc").write_bytes(text if isinstance(text, bytes) else text.encode())
    if road is not None:
        (folder / "road.xodr").write_text(road)
    return read_openscenario(folder / "case.xosc", **options)


def network(folder: Path, text: str) -> OdrNetwork:
    (folder / "road.xodr").write_text(text)
    return read_opendrive(folder / "road.xodr")


def refused(folder: Path, text: str | bytes, road: str | None = None, **options: object) -> InterchangeError:
    """The error that the reader answers with, which always has a place and a cure."""
    with pytest.raises(InterchangeError) as caught:
        read(folder, text, road, **options)
    assert caught.value.place
    assert caught.value.cure
    return caught.value
