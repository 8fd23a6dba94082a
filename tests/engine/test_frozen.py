"""The quick frozen classes behave as those of `dataclasses`."""

import copy
import pickle
from dataclasses import FrozenInstanceError, field, fields, replace

import pytest

from engine.frozen import frozen, frozen_identity


@frozen
class Point:
    x: float
    y: float = 2.0
    tags: list[str] = field(default_factory=list)
    note: str = field(default="", compare=False, repr=False, kw_only=True)


@frozen
class Named(Point):
    name: str = "origin"

    def __repr__(self) -> str:
        return f"<{self.name}>"


@frozen_identity
class Node:
    value: int


def test_fields_and_defaults() -> None:
    """Defaults, factories and keywords are taken as written; each instance has a list of its own."""
    point = Point(1.0, note="here")
    assert (point.x, point.y, point.tags, point.note) == (1.0, 2.0, [], "here")
    assert Point(1.0).tags is not Point(1.0).tags
    assert Point(1.0, tags=["a"]).tags == ["a"]
    assert [each.name for each in fields(Point)] == ["x", "y", "tags", "note"]


def test_nothing_can_be_changed() -> None:
    """Neither set nor deleted."""
    point = Point(1.0)
    with pytest.raises(FrozenInstanceError):
        point.x = 3.0  # pyright: ignore[reportAttributeAccessIssue]
    with pytest.raises(FrozenInstanceError):
        del point.x  # pyright: ignore[reportAttributeAccessIssue]


def test_equality_by_fields() -> None:
    """What is not compared does not count; classes do."""
    assert Point(1.0, note="a") == Point(1.0, note="b")
    assert Point(1.0) != Point(2.0)
    assert Point(1.0) != Named(1.0)
    node = Node(1)
    assert node != Node(1)
    assert len({node, node, Node(1)}) == 2


def test_repr_is_that_of_a_dataclass_or_the_class_own() -> None:
    """A class that says how it is shown is shown so."""
    assert repr(Point(1.0)) == "Point(x=1.0, y=2.0, tags=[])"
    assert repr(Named(1.0)) == "<origin>"


def test_copies() -> None:
    """Replaced, copied and pickled like any other."""
    point = Point(1.0, tags=["a"])
    assert replace(point, y=5.0) == Point(1.0, 5.0, ["a"])
    assert copy.deepcopy(point) == pickle.loads(pickle.dumps(point)) == point


def test_what_follows_from_the_fields_is_set_once() -> None:
    """`__post_init__` sets a field that is no argument, and nothing sets it again; an unknown name is refused, too."""

    @frozen
    class Square:
        side: float
        area: float = field(init=False)

        def __post_init__(self) -> None:
            self.area = self.side**2  # pyright: ignore[reportAttributeAccessIssue]

    square = Square(3.0)
    assert square.area == 9.0
    for name in ("side", "area", "volume"):
        with pytest.raises(FrozenInstanceError, match=name):
            setattr(square, name, 1.0)
