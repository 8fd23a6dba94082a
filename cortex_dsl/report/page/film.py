"""A case as an animated GIF, drawn with Pillow."""

import io
import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from itertools import chain, combinations
from typing import Any

import numpy as np

from cortex_dsl.report.findings.case_replay import CaseReplay, colour, outline_corners
from cortex_dsl.report.findings.framing import BAND, CARD, Frame
from engine.extras import needed
from engine.road.network import SurfaceKind
from engine.road.outline import Outline
from engine.tables import Floats
from engine.vocabulary import State

WIDTHS = {CARD: 720, BAND: 1080}
"""Width of a film by its shape [px]."""
FINE = 2
"""Times as fine as it is shown, so that edges are smooth."""
FRAMES_PER_SECOND = 20
DASH, GAP = 1.6, 2.4
"""Length and gap of the dashes between lanes of one direction, as in `drawing.css` [m]."""
HOLD = 1.2
"""How long contact, and the end, stand still [s]."""
GROUND, ASPHALT, KERB, MARKING, INK = "#f3f1ea", "#d3d6d9", "#8b9198", "#ffffff", "#1b1f24"
BUILDING = "#c9c7c1"
STRIPS = {
    SurfaceKind.SIDEWALK: "#e3e3e1",
    SurfaceKind.SHOULDER: "#afb3b8",
    SurfaceKind.PARKING: "#ced0cd",
    SurfaceKind.BIKE_LANE: "#cd8b71",
}
"""Colours of the strips beside the lanes; these and that of parked cars are mixtures of two colours of the palette."""
PARKED = "#77787e"
ACTORS = ("#0072b2", "#d55e00", "#008f68", "#b0508a", "#8a6d00", "#4a4f55")
HOT, GLASS = "#c8400a", "#f4f6f8"
YELLOW = "#e0a800"
SIGNALS = {"green": ACTORS[2], "yellow": YELLOW, "red": HOT, "": KERB}
"""Colours of lights; few, so that a palette has room for mixtures of any two colours."""


@dataclass(frozen=True)
class Lens:
    """From metres to the pixels of the fine drawing."""

    frame: Frame
    size: tuple[int, int]
    """Width and height [px]."""

    @staticmethod
    def on(frame: Frame) -> "Lens":
        """Return the lens of a frame, with the width of the frame's shape."""
        width = WIDTHS[BAND if frame.is_band else CARD]
        return Lens(frame, (FINE * width, FINE * round(width / frame.shape)))

    @property
    def scale(self) -> float:
        """Pixels that a metre takes."""
        return self.size[0] / self.frame.width

    def __call__(self, points: Floats | list[tuple[float, float]]) -> list[tuple[float, float]]:
        frame = self.frame
        top = frame.bottom + frame.height
        return [
            ((x - frame.left) * self.scale, (top - y) * self.scale)
            for x, y in frame.turned(np.asarray(points, dtype=np.float64)).tolist()
        ]


@dataclass(frozen=True)
class RoadPainter:
    """Paints a road with a drawing of Pillow; `lens` leads from metres to pixels, of which a metre takes `scale`."""

    draw: Any
    lens: Callable[[Floats], list[tuple[float, float]]]
    scale: float

    def fill(self, rings: Iterable[Floats], tint: str) -> None:
        for ring in rings:
            self.draw.polygon(self.lens(ring), fill=tint)

    def lines(self, lines: Iterable[Floats], tint: str, width: int) -> None:
        """Paint lines that are so wide [px]."""
        for line in lines:
            self.draw.line(self.lens(line), fill=tint, width=width)

    def ground(self, road: Outline, asphalt: str, seam: float = 0.0) -> None:
        """Paint strips, lanes, wider by a seam [m], and intersections."""
        for kind, ring in road.strips:
            self.fill([ring], STRIPS[kind])
        for line, width in zip(road.center_lines, road.widths, strict=True):
            self._lane(line, width + seam, asphalt)
        self.fill(road.areas, asphalt)

    def above(self, road: Outline, stripe: str, shadow: str, edge: str, asphalt: str) -> None:
        """Paint crossings, parked cars and bridges."""
        self.fill(road.stripes, stripe)
        self.fill(road.parked, PARKED)
        for line, width, tint in road.deck_coats(shadow, edge, asphalt):
            self._lane(line, width, tint)

    def _lane(self, line: Floats, width: float, tint: str) -> None:
        if width > 0.0:
            self.draw.line(self.lens(line), fill=tint, width=max(1, round(width * self.scale)), joint="curve")


def gif(replay: CaseReplay, speed: float = 1.0) -> bytes:
    """The film of a case.

    Raises:
        MissingExtraError: Pillow is not installed.
    """
    image = needed("PIL.Image", "GIFs need", "report", "pillow")
    lens = Lens.on(replay.frame)
    ground = _ground(replay, lens, image)
    frames, durations = [], []
    for sample, seconds in _shown(replay, speed):
        frames.append(_frame(replay, lens, ground, sample))
        durations.append(max(20, round(1000 * seconds)))
    palette = _palette(image)
    plain = [one.quantize(palette=palette, dither=image.Dither.NONE) for one in frames]
    out = io.BytesIO()
    plain[0].save(out, "GIF", save_all=True, append_images=plain[1:], duration=durations, loop=0, optimize=False)
    return out.getvalue()


def _palette(image: Any) -> Any:
    """Return a palette of our colours and of the mixtures of any two of them, for smooth edges."""
    tints = (GROUND, ASPHALT, KERB, MARKING, INK, HOT, YELLOW, GLASS, BUILDING, *ACTORS, *map(_lighter, ACTORS))
    ours = [tuple(bytes.fromhex(tint[1:])) for tint in tints]
    halfway = [tuple((a + b) // 2 for a, b in zip(*pair, strict=True)) for pair in combinations(ours, 2)]
    palette = image.new("P", (1, 1))
    palette.putpalette([part for tint in (*ours, *halfway) for part in tint])
    return palette


def _shown(replay: CaseReplay, speed: float) -> Iterator[tuple[int, float]]:
    """Samples that are shown, and for how long [s]."""
    time = replay.trajectory.time
    step = float(time[1] - time[0]) if len(time) > 1 else 1.0
    stride = max(1, round(speed / FRAMES_PER_SECOND / step))
    chosen = sorted({*range(0, len(time), stride), replay.key_sample, len(time) - 1})
    for sample, after in zip(chosen, [*chosen[1:], chosen[-1]], strict=True):
        held = sample == len(time) - 1 or (replay.collided and sample == replay.key_sample)
        yield sample, (after - sample) * step / speed + (HOLD if held else 0.0)


def _ground(replay: CaseReplay, lens: Lens, image: Any) -> Any:
    """The road and the ways, which do not move."""
    draw_module = needed("PIL.ImageDraw", "GIFs need", "report", "pillow")
    ground = image.new("RGB", lens.size, GROUND)
    draw, road = draw_module.Draw(ground), replay.road
    painter = RoadPainter(draw, lens, lens.scale)
    painter.fill(road.buildings, BUILDING)
    painter.ground(road, ASPHALT, seam=0.1)
    broken = chain.from_iterable(map(dashes, road.lane_lines))
    painter.lines((*broken, *road.middle_lines), MARKING, max(1, round(0.16 * lens.scale)))
    painter.lines(road.stop_lines, MARKING, round(0.42 * lens.scale))
    painter.lines(road.kerbs, KERB, max(1, round(0.22 * lens.scale)))
    painter.above(road, MARKING, INK, KERB, ASPHALT)
    for actor, way in enumerate(replay.ways):
        for point in lens(way[:: max(1, len(way) // 60)]):
            _disc(draw, point, 0.16 * lens.scale, ACTORS[colour(actor)])
    _compass(draw, lens)
    return ground


def dashes(line: Floats) -> Iterator[Floats]:
    """The painted pieces of a broken line."""
    along = np.concatenate([[0.0], np.hypot(*np.diff(line, axis=0).T).cumsum()])
    for start in np.arange(0.0, along[-1], DASH + GAP):
        end = min(start + DASH, along[-1])
        at = [start, *along[(start < along) & (along < end)], end]
        yield np.column_stack([np.interp(at, along, line[:, axis]) for axis in (0, 1)])


def _compass(draw: Any, lens: Lens) -> None:
    """A north arrow and a bar of a round length, at the lower left."""
    font = needed("PIL.ImageFont", "GIFs need", "report", "pillow").load_default(13 * FINE)
    north, (x, y) = math.radians(lens.frame.north_degrees), (32 * FINE, lens.size[1] - 32 * FINE)
    needle = [(0.0, 11.0), (6.0, -8.0), (0.0, -4.0), (-6.0, -8.0)]
    cos, sin = FINE * math.cos(north), FINE * math.sin(north)
    draw.polygon([(x + cos * u + sin * v, y + sin * u - cos * v) for u, v in needle], fill=INK)
    draw.text((x + 20 * sin, y - 20 * cos), "N", fill=INK, font=font, anchor="mm")
    left, right, low = 62 * FINE, 62 * FINE + round(lens.frame.bar * lens.scale), y + 18 * FINE
    draw.line([(left, low - 5 * FINE), (left, low), (right, low), (right, low - 5 * FINE)], fill=INK, width=FINE)
    draw.text((left + 6 * FINE, low - 5 * FINE), f"{lens.frame.bar} m", fill=INK, font=font, anchor="ls")


def _frame(replay: CaseReplay, lens: Lens, ground: Any, sample: int) -> Any:
    draw_module = needed("PIL.ImageDraw", "GIFs need", "report", "pillow")
    fine = ground.copy()
    draw = draw_module.Draw(fine)
    after = replay.collided and sample > replay.trajectory.contact_sample
    time = float(replay.trajectory.time[sample])
    for each in replay.road.signals:
        draw.line(lens(each.line), fill=SIGNALS[each.colour(time)], width=round(0.7 * lens.scale))
    for actor in reversed(range(len(replay.shapes))):
        _actor(draw, replay, lens, actor, sample, after)
    if replay.contact_point and after:
        _cross(draw, lens([replay.contact_point])[0], 0.7 * lens.scale)
    small = fine.resize((fine.width // FINE, fine.height // FINE))
    _caption(draw_module.Draw(small), replay, sample, after)
    return small


def _actor(draw: Any, replay: CaseReplay, lens: Lens, actor: int, sample: int, after: bool) -> None:
    state, shape = replay.trajectory.states[sample, actor], replay.shapes[actor]
    if state[State.PRESENT] < 0.5 or not np.isfinite(state[: State.HEADING + 1]).all():
        return
    x, y, heading = (float(v) for v in state[[State.X, State.Y, State.HEADING]])
    corners = lens(outline_corners(x, y, heading, shape.length, shape.width))
    tint = _lighter(ACTORS[colour(actor)]) if after else ACTORS[colour(actor)]
    draw.polygon(corners, fill=tint, outline=INK, width=max(1, FINE // 2))
    ahead = 0.14 * shape.length
    glass = (x + ahead * np.cos(heading), y + ahead * np.sin(heading))
    draw.polygon(lens(outline_corners(*glass, heading, 0.16 * shape.length, 0.76 * shape.width)), fill=GLASS)


def _lighter(tint: str) -> str:
    """Halfway to the asphalt."""
    pairs = [(int(tint[k : k + 2], 16) + int(ASPHALT[k : k + 2], 16)) // 2 for k in (1, 3, 5)]
    return "#" + "".join(f"{value:02x}" for value in pairs)


def _cross(draw: Any, point: tuple[float, float], size: float) -> None:
    x, y = point
    for side in (-1, 1):
        draw.line([(x - size, y - side * size), (x + size, y + side * size)], fill=HOT, width=round(size / 1.6))


def _disc(draw: Any, point: tuple[float, float], size: float, tint: str) -> None:
    x, y = point
    draw.ellipse([x - size, y - size, x + size, y + size], fill=tint)


def _caption(draw: Any, replay: CaseReplay, sample: int, after: bool) -> None:
    font = needed("PIL.ImageFont", "GIFs need", "report", "pillow").load_default(15)
    draw.text((14, 12), f"{replay.trajectory.time[sample]:.2f} s", fill=INK, font=font)
    for actor, shape in enumerate(replay.shapes):
        now = float(replay.speeds[sample, actor])
        speed = replay.unit.text(now, 0) if np.isfinite(now) else "-"
        draw.text((14, 34 + 20 * actor), f"{shape.name}  {speed}", fill=ACTORS[colour(actor)], font=font)
    if after:
        draw.text((14, 34 + 20 * len(replay.shapes)), "after contact: not scored", fill=KERB, font=font)
