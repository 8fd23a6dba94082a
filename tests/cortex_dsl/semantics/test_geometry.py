"""Places and the operators between them, as expressions."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from engine.opcodes import Op


def literals(items: tuple[ir.Expr, ...]) -> list[float | None]:
    """Numbers that are known, None for the others."""
    return [item.value if isinstance(item, ir.Literal) else None for item in items]


def outlines(condition: ir.Expr) -> list[list[float | None]]:
    """What is known of the two outlines whose distance a condition compares."""
    assert isinstance(condition, ir.Apply)
    (gap,) = (each for each in condition.arguments if isinstance(each, ir.Apply))
    assert gap.op is Op.BOX_DISTANCE
    return [literals(each.items) for each in gap.arguments if isinstance(each, ir.Pack)]


@pytest.mark.parametrize("place", ["(30 m, 4 m)", "30 m @ 4 m", "mark"])
def test_a_point_is_an_outline_of_no_size(compiled: Callable[..., ir.Scenario], place: str) -> None:
    """`minimum distance` to a point ends at the point itself: x, y, and no heading, length or width."""
    text = f"mark = new Point at (30 m, 4 m)\nrequire (minimum distance from ego to {place}) > 2 m\n"
    condition = compiled(text).variants[0].requirements[0].condition
    box, point = outlines(condition)
    assert point == [30.0, 4.0, 0.0, 0.0, 0.0]
    assert None not in box[3:]
    assert min(length for length in box[3:] if length is not None) > 1.0, "a car has a size"


def test_an_offset_turns_with_its_frame(compiled: Callable[..., ir.Scenario]) -> None:
    """(to the right, ahead): 2 m to the right of a heading of 0 is 2 m along -y."""
    text = "box = new Obstacle at (mark offset by (2 m, 10 m)), with regionContainedIn None\n"
    scenario = compiled("mark = new OrientedPoint at (5 m, 7 m), facing 0 deg\n" + text)
    x, y = scenario.variants[0].actors[1].columns[:2]
    numbers = {part.value for part in _parts(x) if isinstance(part, ir.Literal)}
    assert {5.0, 10.0, 2.0} <= numbers
    assert isinstance(y, ir.Apply)
    assert (y.op, y.arguments[1].op) == (Op.ADD, Op.SUB)  # type: ignore[attr-defined]


def _parts(expression: ir.Expr) -> list[ir.Expr]:
    inner = expression.arguments if isinstance(expression, ir.Apply) else ()
    return [expression, *(part for each in inner for part in _parts(each))]
