"""A case played in a terminal: the braille drawing of a scene, frame after frame."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from time import monotonic, sleep

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.text import Text

from cortex_dsl.report.blocks import actor_style
from cortex_dsl.report.findings.case_replay import CaseReplay, outline_corners
from cortex_dsl.report.findings.readable import NOT_LEVEL, fixed
from cortex_dsl.report.terminal.canvas import Canvas
from cortex_dsl.report.terminal.scene_view import DRAWING_COLUMNS, draw_scene, mark_signals
from engine.metrics import apart_in_height
from engine.vocabulary import State

FRAMES_PER_SECOND = 20.0
PAUSE = 1.0
"""Pause at contact before the run continues [s]."""


@dataclass(frozen=True)
class Film:
    """A case and the drawing of all that does not move."""

    replay: CaseReplay
    still: Canvas
    ascii_only: bool

    @staticmethod
    def of(replay: CaseReplay, width: int, height: int, *, ascii_only: bool) -> "Film":
        """Return a film with a drawing that fits a console of this size; the rows are half of its columns less four."""
        columns = max(28, min(DRAWING_COLUMNS, width - 4, 2 * (height - 3 + 4)))
        return Film(
            replay, draw_scene(replay.road, replay.trajectory, None, columns, ascii_only=ascii_only), ascii_only
        )

    def frame(self, place: float) -> RenderableType:
        """Return the frame at a time between samples: every actor, and the measures at that time."""
        canvas = replace(self.still, dots=dict(self.still.dots), styles=dict(self.still.styles), marks={})
        for actor in reversed(range(len(self.replay.shapes))):
            self._draw(canvas, actor, place)
        mark_signals(canvas, self.replay.road, place * self._step)
        if self.replay.contact_point and place * self._step >= self.replay.key_time - 1e-9:
            canvas.mark(self.replay.contact_point, "X" if self.ascii_only else "✕", "bad")
        drawing = Text("\n").join(canvas.lines(ascii_only=self.ascii_only))
        return Group(drawing, *self._lines(place))

    def _draw(self, canvas: Canvas, actor: int, place: float) -> None:
        pose = self._pose(actor, place)
        if pose is not None:
            shape = self.replay.shapes[actor]
            canvas.fill(outline_corners(*pose, shape.length, shape.width), actor_style(actor))

    def _pose(self, actor: int, place: float) -> tuple[float, float, float] | None:
        """x, y, heading; None while the actor is not in the scene."""
        before = min(math.floor(place), len(self.replay.trajectory.time) - 1)
        after = min(before + 1, len(self.replay.trajectory.time) - 1)
        a, b = self.replay.trajectory.states[[before, after], actor]
        poses = np.array([a[: State.HEADING + 1], b[: State.HEADING + 1]])
        if a[State.PRESENT] < 0.5 or not np.isfinite(poses[0]).all():
            return None
        if b[State.PRESENT] < 0.5 or not np.isfinite(poses[1]).all():
            poses[1] = poses[0]
        turn = math.remainder(poses[1, 2] - poses[0, 2], 2.0 * math.pi)
        x, y = poses[0, :2] + (place - before) * (poses[1, :2] - poses[0, :2])
        return float(x), float(y), float(poses[0, 2] + (place - before) * turn)

    @property
    def _step(self) -> float:
        time = self.replay.trajectory.time
        return float(time[1] - time[0]) if len(time) > 1 else 1.0

    def _lines(self, place: float) -> Iterator[Text]:
        sample = min(round(place), len(self.replay.trajectory.time) - 1)
        if self.replay.collided and place * self._step <= self.replay.key_time + 1e-9:
            sample = min(sample, self.replay.trajectory.contact_sample)  # at contact the line shows the preceding value
        line = Text.assemble((f"{place * self._step:6.2f} s  ", "title"))
        for actor, shape in enumerate(self.replay.shapes):
            speed = self.replay.unit.text(float(self.replay.speeds[sample, actor]))
            line.append(f" {shape.name} {speed} ", actor_style(actor))
        yield line
        yield Text(self._event(place, sample), "quiet")

    def _event(self, place: float, sample: int) -> str:
        """Return the distance of the deciding pair, or a note after contact."""
        replay = self.replay
        since = place * self._step - replay.key_time
        if replay.collided and since >= -1e-9:
            return "contact" if since < self._step else "after contact: physics for illustration, not scored"
        apart = float(replay.approach.distance[sample])
        other = replay.shapes[replay.pair + 1].name if len(replay.shapes) > 1 else ""
        if not math.isfinite(apart):
            level = other and apart_in_height(replay.trajectory, replay.pair + 1)[sample]
            return f"{other} is {NOT_LEVEL} with {replay.shapes[0].name}" if level else ""
        closing = float(replay.approach.closing_speed[sample])
        speed = replay.unit.text(abs(closing))
        return f"{other} {fixed(apart, 2)} m away, {'closing' if closing >= 0.0 else 'going apart'} at {speed}"


def play(replay: CaseReplay, console: Console, speed: float = 1.0) -> None:
    """Play a case in the console's terminal, or draw its key moment where the output is no terminal."""
    film = Film.of(replay, console.width, console.height, ascii_only=console.options.ascii_only)
    step = float(replay.trajectory.time[1]) if len(replay.trajectory.time) > 1 else 1.0
    if not console.is_terminal or console.is_dumb_terminal:
        console.print(film.frame(replay.key_time / step))
        return
    with Live(console=console, auto_refresh=False, transient=False) as live:
        for time in _times(replay, speed):
            live.update(film.frame(time / step), refresh=True)


def _times(replay: CaseReplay, speed: float) -> Iterator[float]:
    """Yield the simulated time of each frame at the given speed, with a pause at contact."""
    last, start, paused = float(replay.trajectory.time[-1]), monotonic(), not replay.collided
    pause = 0.0
    while (now := speed * (monotonic() - start - pause)) < last:
        if not paused and now >= replay.key_time:
            paused = True
            yield replay.key_time
            sleep(PAUSE)
            pause += PAUSE
        else:
            yield now
            sleep(1.0 / FRAMES_PER_SECOND)
    yield last
