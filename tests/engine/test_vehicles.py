"""The table of actor kinds is complete and its rows are possible vehicles."""

import math

import pytest

from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column

PLACED = {Column.X, Column.Y, Column.HEADING, Column.SPEED}
WHEELED = [ActorKind.CAR, ActorKind.TRUCK, ActorKind.BUS, ActorKind.MOTORCYCLE, ActorKind.BICYCLE]


@pytest.mark.parametrize("kind", ActorKind)
def test_every_kind_has_a_default_for_every_column(kind: ActorKind) -> None:
    """A scene can be filled from the table: all columns but the place are fields of the model."""
    for column in set(Column) - PLACED:
        assert math.isfinite(getattr(MODELS[kind], column.name.lower()))


@pytest.mark.parametrize("kind", WHEELED)
def test_axles_lie_within_the_outline(kind: ActorKind) -> None:
    """Both axles are under the body, wherever its centre is."""
    model = MODELS[kind]
    assert model.rear_to_center < model.length / 2
    assert model.wheelbase - model.rear_to_center < model.length / 2


def test_the_car_is_the_one_of_the_reference() -> None:
    """BMW 320i: 4.508 x 1.610 m, wheelbase 2.579 m, 1093 kg, 1792 kg m^2, full braking 8, throttle 3 m/s^2."""
    car = MODELS[ActorKind.CAR]
    assert (car.length, car.width, car.wheelbase) == (4.508, 1.610, 2.579)
    assert (car.mass, car.yaw_inertia, car.max_braking, car.max_acceleration) == (1093.0, 1792.0, 8.0, 3.0)
