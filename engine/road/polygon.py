"""Simple polygons as (n, 2) rings of vertices, anticlockwise, without a repeated last vertex. Metres."""

import numpy as np

from engine.tables import Floats


def area(ring: Floats) -> float:
    """Signed area: positive when the ring is anticlockwise [m^2]."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1)))


def anticlockwise(ring: Floats) -> Floats:
    return ring if area(ring) > 0.0 else ring[::-1]


def edges(ring: Floats) -> Floats:
    """(n, 4): x1, y1, x2, y2 of each edge."""
    return np.hstack([ring, np.roll(ring, -1, axis=0)])


def convex_hull(points: Floats) -> Floats:
    """Corners of the hull, anticlockwise (monotone chain); points on a hull edge are left out."""
    ordered = sorted({(float(x), float(y)) for x, y in points})
    lower, upper = _chain(ordered), _chain(ordered[::-1])
    return np.array(lower[:-1] + upper[:-1])


def _chain(ordered: list[tuple[float, float]]) -> list[tuple[float, float]]:
    chain: list[tuple[float, float]] = []
    for point in ordered:
        while len(chain) >= 2 and _turn(chain[-2], chain[-1], point) <= 0.0:
            chain.pop()
        chain.append(point)
    return chain


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the signed area of a triangle: positive where the way a, b, c turns left."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def triangulate(ring: Floats) -> Floats:
    """(n - 2, 6) triangles x1, y1, x2, y2, x3, y3 that tile a simple anticlockwise ring, by ear clipping."""
    left = [(float(x), float(y)) for x, y in ring]
    triangles: list[tuple[float, ...]] = []
    while len(left) > 3:
        index = _best_ear(left)
        triangles.append((*left[index - 1], *left[index], *left[(index + 1) % len(left)]))
        del left[index]
    triangles.append((*left[0], *left[1], *left[2]))
    return np.array(triangles)


def _best_ear(ring: list[tuple[float, float]]) -> int:
    """The first convex vertex whose triangle holds no other vertex; the flattest would do where rounding hides it."""
    for index in range(len(ring)):
        a, b, c = ring[index - 1], ring[index], ring[(index + 1) % len(ring)]
        if _turn(a, b, c) > 0.0 and not any(_inside(a, b, c, point) for point in ring if point not in (a, b, c)):
            return index
    return min(range(len(ring)), key=lambda i: abs(_turn(ring[i - 1], ring[i], ring[(i + 1) % len(ring)])))


def _inside(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float], point: tuple[float, float]) -> bool:
    """Whether a point lies in the anticlockwise triangle or on its boundary."""
    return _turn(a, b, point) >= 0.0 and _turn(b, c, point) >= 0.0 and _turn(c, a, point) >= 0.0
