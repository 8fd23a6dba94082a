"""A small drawing made of characters: braille dots where the terminal has them, plain ASCII where not.

World coordinates are metres; the heading of a window points to the right. A character holds 2 x 4 dots, so dots are
about square.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise

from rich.text import Text

Point = tuple[float, float]

DOT_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""Braille bit of a dot: row from the top, then column."""
BRAILLE = 0x2800


@dataclass(frozen=True)
class Window:
    """The part of the world that is shown: its centre, the dots that a metre takes, and how it is turned."""

    x: float
    y: float
    scale: float
    heading: float = 0.0
    """Direction of the world that points to the right [rad]."""

    @staticmethod
    def around(points: Iterable[Point], columns: int, rows: int, margin: float, heading: float = 0.0) -> "Window":
        """The window that shows all points and a margin [m] in columns x rows characters."""
        turned = Window(0.0, 0.0, 1.0, heading)
        xs, ys = zip(*map(turned.seen, points), strict=True)
        width = max(xs) - min(xs) + 2 * margin
        height = max(ys) - min(ys) + 2 * margin
        scale = min(2 * columns / width, 4 * rows / height)
        x, y = turned.place((max(xs) + min(xs)) / 2, (max(ys) + min(ys)) / 2)
        return Window(x, y, scale, heading)

    def seen(self, point: Point) -> Point:
        """A point of the world from the centre: dots to the right, and up."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        x, y = point[0] - self.x, point[1] - self.y
        return (cos * x + sin * y) * self.scale, (cos * y - sin * x) * self.scale

    def place(self, right: float, up: float) -> Point:
        """The point of the world so many dots to the right of the centre and above it."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return self.x + (cos * right - sin * up) / self.scale, self.y + (sin * right + cos * up) / self.scale


@dataclass
class Canvas:
    """Characters under construction. Later drawings cover earlier ones; a character shows its topmost colour."""

    columns: int
    rows: int
    window: Window
    dots: dict[tuple[int, int], int] = field(default_factory=dict)
    """Braille bits by (row, column)."""
    styles: dict[tuple[int, int], str] = field(default_factory=dict)
    marks: dict[tuple[int, int], tuple[str, str]] = field(default_factory=dict)
    """Characters that stand over the dots: (character, style)."""

    def line(self, points: Sequence[Point], style: str, *, on: int = 1, off: int = 0) -> None:
        """A polyline; `on` dots drawn, then `off` left out, and so on along it."""
        count = 0
        for start, end in pairwise(points):
            for dot in self._dots_between(start, end):
                if count % (on + off) < on:
                    self._set(dot, style)
                count += 1

    def fill(self, corners: Sequence[Point], style: str) -> None:
        """A convex polygon, corners anticlockwise; its outline is drawn even where it is thinner than a dot."""
        self.line([*corners, corners[0]], style)
        dots = [self._dot(p) for p in corners]
        for x in range(min(d[0] for d in dots), max(d[0] for d in dots) + 1):
            for y in range(min(d[1] for d in dots), max(d[1] for d in dots) + 1):
                if _inside(self._world(x, y), corners):
                    self._set((x, y), style)

    def mark(self, point: Point, character: str, style: str) -> None:
        """One character over everything else."""
        x, y = self._dot(point)
        cell = (y // 4, x // 2)
        if self._visible(cell):
            self.marks[cell] = (character, style)

    def lines(self, *, ascii_only: bool = False) -> list[Text]:
        """The drawing, one text a row, from the top."""
        return [self._row(row, ascii_only) for row in range(self.rows)]

    def cropped(self, *, ascii_only: bool = False) -> list[Text]:
        """Return the lines without the empty rows above and below the drawing."""
        rows = [row for row, _ in (*self.dots, *self.marks)]
        return self.lines(ascii_only=ascii_only)[min(rows) : max(rows) + 1] if rows else []

    def _row(self, row: int, ascii_only: bool) -> Text:
        text = Text()
        cells = (self._cell((row, column), ascii_only) for column in range(self.columns))
        for style, run in groupby(cells, key=lambda cell: cell[1]):
            text.append("".join(character for character, _ in run), style)
        return text

    def _cell(self, cell: tuple[int, int], ascii_only: bool) -> tuple[str, str]:
        if cell in self.marks:
            return self.marks[cell]
        if cell in self.dots:
            bits = self.dots[cell]
            return _ascii(bits) if ascii_only else chr(BRAILLE + bits), self.styles[cell]
        return " ", ""

    def _dots_between(self, start: Point, end: Point) -> Iterable[tuple[int, int]]:
        """The dots of a straight line, its end left out."""
        (x0, y0), (x1, y1) = self._dot(start), self._dot(end)
        steps = max(abs(x1 - x0), abs(y1 - y0))
        for i in range(steps):
            yield round(x0 + (x1 - x0) * i / steps), round(y0 + (y1 - y0) * i / steps)

    def _dot(self, point: Point) -> tuple[int, int]:
        right, up = self.window.seen(point)
        return math.floor(self.columns + right), math.floor(2 * self.rows - up)

    def _world(self, x: int, y: int) -> Point:
        """The centre of a dot [m]."""
        return self.window.place(x + 0.5 - self.columns, 2 * self.rows - y - 0.5)

    def _set(self, dot: tuple[int, int], style: str) -> None:
        cell = (dot[1] // 4, dot[0] // 2)
        if self._visible(cell):
            self.dots[cell] = self.dots.get(cell, 0) | DOT_BITS[dot[1] % 4][dot[0] % 2]
            self.styles[cell] = style

    def _visible(self, cell: tuple[int, int]) -> bool:
        return 0 <= cell[0] < self.rows and 0 <= cell[1] < self.columns


def _inside(point: Point, corners: Sequence[Point]) -> bool:
    return all(
        (bx - ax) * (point[1] - ay) - (by - ay) * (point[0] - ax) >= 0
        for (ax, ay), (bx, by) in zip(corners, [*corners[1:], corners[0]], strict=True)
    )


def _ascii(bits: int) -> str:
    """The plain character nearest to a pattern of dots."""
    top, bottom = bits & 0x1B, bits & 0xE4
    if bits.bit_count() >= 5:
        return "#"
    return "." if not top else "'" if not bottom else ":"
