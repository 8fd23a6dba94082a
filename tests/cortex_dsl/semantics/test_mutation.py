"""`mutate`: normal noise on place and heading, seen by all that is placed relative to the object."""

from collections.abc import Callable

import numpy as np
import pytest

from cortex_dsl import compile_text
from engine.vocabulary import Column

MAP = "map intersection(ways=4, lanes=2, approach=80 m)\n"
EGO = "ego = new Obstacle at (3 m, 5 m), facing 0.2 rad, with regionContainedIn None, with allowCollisions True\n"


def _columns(text: str, actor: int = 0) -> np.ndarray:
    """(scenes, columns) of an object at the start."""
    scenes = compile_text(MAP + text).sample(20_000, seed=3)
    width = len(Column)
    return scenes.values[scenes.valid, actor * width : (actor + 1) * width]


@pytest.mark.parametrize("scale", [1.0, 0.5])
def test_the_noise_has_its_deviations(scale: float) -> None:
    """1 m in x and y, 5 degrees in heading, times the scale; independent of one another."""
    drawn = _columns(EGO + f"mutate ego by {scale}\n")
    places = drawn[:, [Column.X, Column.Y, Column.HEADING]]
    np.testing.assert_allclose(places.mean(axis=0), [3.0, 5.0, 0.2], atol=0.03)
    np.testing.assert_allclose(places.std(axis=0) / scale, [1.0, 1.0, np.radians(5.0)], rtol=0.03)
    assert np.abs(np.corrcoef(places.T) - np.eye(3)).max() < 0.03


def test_what_is_placed_beside_sees_the_noise() -> None:
    """An object 9 m ahead is 9 m ahead of where the mutated one really is."""
    text = EGO + "b = new Obstacle at ego offset by (0, 9 m), with regionContainedIn None\nmutate ego\n"
    scenes = compile_text(MAP + text).sample(200, seed=3)
    values, width = scenes.values[scenes.valid], len(Column)
    ego, other = values[:, :width], values[:, width : 2 * width]
    gap = np.hypot(other[:, Column.X] - ego[:, Column.X], other[:, Column.Y] - ego[:, Column.Y])
    np.testing.assert_allclose(gap, 9.0, rtol=1e-12)


def test_without_names_all_objects_above_are_meant() -> None:
    text = MAP + EGO + "mutate\nb = new Obstacle at (9 m, 5 m), with regionContainedIn None\n"
    first, second = (compile_text(text).sample(50).values[:, i * len(Column) :] for i in range(2))
    assert np.ptp(first[:, Column.X]) > 0.0
    assert np.ptp(second[:, Column.X]) == 0.0


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("mutate eg\n", "SCN201"),
        ("mutate ego by -1\n", "SCN402"),
        ("cars = [new Car at (9 m, 2 m)]\nmutate cars\n", "SCN239"),
        ("mutate ego by 2 m\n", "SCN301"),
    ],
)
def test_mistakes_are_reported(said: Callable[[str], list[str]], text: str, code: str) -> None:
    assert code in said(text)
