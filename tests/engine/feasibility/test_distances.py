"""Distances from the border of a large region, of which only what is near is looked at."""

import numpy as np
import pytest

from engine.feasibility import distances
from engine.tables import Floats


def town(rng: np.random.Generator, corners: int) -> Floats:
    """Edges of a jagged ring of a kilometre, and of small squares with level and upright sides in it."""
    turns = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    radii = 500.0 + rng.uniform(-30.0, 30.0, corners)
    rings = [np.stack([radii * np.cos(turns), radii * np.sin(turns)], axis=1)]
    corner = np.array([[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]])
    rings.extend(middle + corner for middle in rng.uniform(-250.0, 250.0, (40, 2)).round())
    return np.concatenate([np.hstack([ring, np.roll(ring, -1, axis=0)]) for ring in rings])


@pytest.mark.parametrize("count", [0, 1, 3000])
def test_what_is_left_out_changes_no_bit(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(count)
    edges = town(rng, 2 * distances.MANY)
    x, y = rng.uniform(-600.0, 600.0, (2, count))
    on = count // 4  # corners themselves, points level with one, and points far away
    x[:on], y[:on] = edges[:on, 0], edges[:on, 1]
    y[on : 2 * on] = edges[:on, 3]
    x[:1] = 4.0e4
    with np.errstate(all="ignore"):
        found = distances.boundary_distance(edges, x, y)
        monkeypatch.setattr(distances, "MANY", len(edges) + 1)
        of_all = distances.boundary_distance(edges, x, y)
    assert np.array_equal(found[0], of_all[0])
    assert np.array_equal(found[1], of_all[1])
    assert count < 3000 or 0.2 < found[1].mean() < 0.8


def test_an_edge_without_length_makes_everything_unknown_wherever_it_lies() -> None:
    edges = town(np.random.default_rng(1), 2 * distances.MANY)
    edges[7, 2:] = edges[7, :2]
    with np.errstate(all="ignore"):
        distance, _ = distances.boundary_distance(edges, np.array([0.0, 450.0]), np.array([0.0, -20.0]))
    assert np.isnan(distance).all()
