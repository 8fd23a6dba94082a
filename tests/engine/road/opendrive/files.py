"""OpenDRIVE texts for the tests of roads of files: small roads with links, and ways to move a file."""

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from engine.maps import digest_of
from engine.road.network import Network
from engine.road.opendrive.linking import Links
from engine.road.opendrive.making import built
from engine.road.opendrive.planning import Plan, plan_of

EXAMPLES = Path(__file__).parents[4] / "examples" / "roads"
LANE = '<lane id="{0}" type="driving"><link>{1}</link><width sOffset="0" a="{2}" b="{3}" c="0" d="0"/></lane>'


def lane(number: int, before: int | None = None, after: int | None = None, a: float = 3.5, b: float = 0.0) -> str:
    links = "".join(
        f'<{name} id="{to}"/>' for name, to in (("predecessor", before), ("successor", after)) if to is not None
    )
    return LANE.format(number, links, a, b)


def section(left: Sequence[str] = (), right: Sequence[str] = (), s: float = 0.0, more: str = "") -> str:
    sides = "".join(f"<{name}>{''.join(lanes)}</{name}>" for name, lanes in (("left", left), ("right", right)) if lanes)
    return f'<laneSection s="{s}" {more}>{sides}</laneSection>'


def road(
    name: str,
    sections: str,
    link: str = "",
    *,
    length: float = 50.0,
    junction: str = "-1",
    place: Mapping[str, float] = MappingProxyType({}),
) -> str:
    """Return a straight road, or an arc of a `curvature`, from `x`, `y` in the direction `hdg`; `height` raises it."""
    curve = f'<arc curvature="{place["curvature"]}"/>' if "curvature" in place else "<line/>"
    height = f'<elevationProfile><elevation s="0" a="{place.get("height")}" b="0" c="0" d="0"/></elevationProfile>'
    x, y, heading = (place.get(name, 0.0) for name in ("x", "y", "hdg"))
    return (
        f'<road id="{name}" length="{length}" junction="{junction}"><link>{link}</link><planView>'
        f'<geometry s="0" x="{x}" y="{y}" hdg="{heading}" length="{length}">{curve}</geometry></planView>'
        f"{height if 'height' in place else ''}<lanes>{sections}</lanes></road>"
    )


def link(name: str, to: str, contact: str) -> str:
    return f'<{name} elementType="road" elementId="{to}" contactPoint="{contact}"/>'


def written(folder: Path, *elements: str) -> Path:
    """Return the file of some roads and junctions."""
    path = folder / "road.xodr"
    path.write_text(f"<OpenDRIVE>{''.join(elements)}</OpenDRIVE>")
    return path


def plan(path: Path) -> Plan:
    return plan_of(str(path), digest_of(path))


def network(path: Path) -> Network:
    return built(str(path), digest_of(path))


def graph(links: Links) -> set[tuple[tuple[str, int], ...]]:
    """Return which lane leads into which, by road and number: pairs, and the ways through junctions."""

    def named(index: int) -> tuple[str, int]:
        return links.lanes[index].road, links.lanes[index].first.lane

    pairs = {(named(one), named(other)) for one, following in links.successors.items() for other in following}
    return pairs | {tuple(map(named, way[1:])) for way in links.ways}


def moved(text: str, dx: float, dy: float, turn: float) -> str:
    """Return a file whose roads are all turned about the origin, and moved."""

    def place(found: re.Match[str]) -> str:
        x, y, heading = (float(found[name]) for name in ("x", "y", "hdg"))
        cos, sin = math.cos(turn), math.sin(turn)
        return f'x="{dx + x * cos - y * sin!r}" y="{dy + x * sin + y * cos!r}" hdg="{heading + turn!r}"'

    return re.sub(r'x="(?P<x>[^"]*)" y="(?P<y>[^"]*)" hdg="(?P<hdg>[^"]*)"', place, text)
