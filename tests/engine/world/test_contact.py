"""Contact physics on its own: the laws of mechanics, and what an impact's record says."""

import itertools
import math
from collections.abc import Callable

import pymunk
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.config import ContactConfig
from engine.kernels.impacts.motion import PULSE
from engine.scenes import Impact
from engine.vehicles import CAR, MODELS
from engine.vocabulary import ActorKind, Column
from engine.world.bodies import Physique, new_space, physique, rub, solid
from engine.world.impacts import Recorder, clock_position
from tests.laws import examples

SUBSTEP = 0.0025
CONFIG = ContactConfig()
Motion = tuple[float, float, float, float, float, float]
"""x, y, heading; vx, vy, spin."""


def actor(kind: ActorKind = ActorKind.CAR, **changes: float) -> Physique:
    model = MODELS[kind]
    columns = [float(getattr(model, column.name.lower(), 0.0)) for column in Column]
    for name, value in changes.items():
        columns[Column[name.upper()]] = value
    return physique(kind, columns)


def kinetic_energy(body: pymunk.Body) -> float:
    """Of a moving body [J]; `Body.kinetic_energy` is twice this."""
    return 0.5 * (body.mass * body.velocity.dot(body.velocity) + body.moment * body.angular_velocity**2)


def motion(body: pymunk.Body) -> Motion:
    (x, y), (vx, vy) = body.position, body.velocity
    return x, y, body.angle, vx, vy, body.angular_velocity


class Crash:
    """Bodies in a space, stepped without friction on the road."""

    def __init__(self, *actors: tuple[Physique, Motion]) -> None:
        self.space = new_space(CONFIG)
        self.actors = [physique for physique, _ in actors]
        self.bodies = [solid(self.space, physique, CONFIG) for physique in self.actors]
        self.recorder = Recorder(self.space, self.bodies)
        for body, (_, (x, y, heading, vx, vy, spin)) in zip(self.bodies, actors, strict=True):
            body.position, body.angle = (x, y), heading
            if body.body_type == pymunk.Body.DYNAMIC:
                body.velocity, body.angular_velocity = (vx, vy), spin
            self.space.reindex_shapes_for_body(body)

    def step(self, count: int, each: Callable[[], object] = lambda: None) -> "Crash":
        for _ in range(count):
            self.recorder.time += SUBSTEP
            self.space.step(SUBSTEP)
            self.recorder.check()
            each()
        return self

    @property
    def moving(self) -> list[pymunk.Body]:
        return [body for body in self.bodies if body.body_type == pymunk.Body.DYNAMIC]

    def momentum(self) -> pymunk.Vec2d:
        return sum((body.mass * body.velocity for body in self.moving), pymunk.Vec2d(0, 0))

    def energy(self) -> float:
        return sum(map(kinetic_energy, self.moving))

    def impacts(self, least_change: float = 0.0) -> tuple[Impact, ...]:
        """Every touch, however slight, so that impulses add up."""
        masses = tuple(math.inf if one.fixed else one.mass for one in self.actors)
        return self.recorder.impacts(masses, least_change)


@st.composite
def crashes(draw: st.DrawFn) -> Crash:
    """Two vehicles about to meet somewhere near the origin."""
    heading, speed = st.floats(-3.0, 3.0), st.floats(3.0, 25.0)
    kinds = st.sampled_from([ActorKind.CAR, ActorKind.TRUCK, ActorKind.MOTORCYCLE])

    def vehicle(early: float) -> tuple[Physique, Motion]:
        h, v, spin = draw(heading), draw(speed), draw(st.floats(-0.5, 0.5))
        vx, vy = v * math.cos(h), v * math.sin(h)
        aside = draw(st.floats(-1.0, 1.0))
        place = (-vx * early - aside * math.sin(h), -vy * early + aside * math.cos(h))
        return actor(draw(kinds)), (*place, h, vx, vy, spin)

    one, other = vehicle(1.2), vehicle(1.2)
    return Crash(one, other)


@examples(40)
@given(crashes())
def test_momentum_holds_and_energy_never_rises(crash: Crash) -> None:
    """Through first and later impacts, at every substep."""
    momentum, energies = crash.momentum(), [crash.energy()]
    crash.step(800, lambda: energies.append(crash.energy()))
    size = sum(body.mass * body.velocity.length for body in crash.bodies) + momentum.length
    assert (crash.momentum() - momentum).length <= 1e-9 * size
    assert all(after <= before * (1.0 + 1e-12) for before, after in itertools.pairwise(energies))


@examples(40)
@given(crashes())
def test_impulses_are_the_changes_of_velocity(crash: Crash) -> None:
    """|sum of impulses| / m is the change of velocity, and m1 dV1 = m2 dV2."""
    before = [body.velocity for body in crash.bodies]
    headings: list[float] = []
    crash.step(800, lambda: headings or not crash.recorder.struck or headings.extend(b.angle for b in crash.bodies))
    impacts = crash.impacts()
    changes = [(body.velocity - start).length for body, start in zip(crash.bodies, before, strict=True)]
    assert impacts or max(changes) < 0.02
    for impact in impacts:
        assert crash.actors[0].mass * impact.delta_v[0] == pytest.approx(crash.actors[1].mass * impact.delta_v[1])
    if len(impacts) == 1 and all(e.last - e.start <= PULSE for e in crash.recorder.episodes):
        for side, body in enumerate(crash.bodies):
            change = body.velocity - before[side]
            said = pymunk.Vec2d(impacts[0].delta_v[side], 0).rotated(impacts[0].direction[side] + headings[side])
            assert (change - said).length <= 1e-9 + 0.01 * change.length  # the heading is that of a substep earlier
            assert change.length == pytest.approx(impacts[0].delta_v[side], abs=1e-9)


@examples(10)
@given(st.data())
def test_a_crash_repeats_bit_for_bit(data: st.DataObject) -> None:
    """The same start leads to the same numbers to the last bit."""
    start = data.draw(crashes())
    poses = [motion(body) for body in start.bodies]

    def run() -> list[Motion]:
        crash = Crash(*zip(start.actors, poses, strict=True)).step(600)
        return [motion(body) for body in crash.bodies]

    assert run() == run()


def test_head_on_crash_of_equals_has_the_known_change_of_velocity() -> None:
    """Restitution 0.15: each changes by (1 + e) / 2 of the closing speed, straight back."""
    length = CAR.length
    crash = Crash((actor(), (0, 0, 0, 10, 0, 0)), (actor(), (length + 0.5, 0, math.pi, -10, 0, 0))).step(200)
    (impact,) = crash.impacts()
    assert impact.delta_v == pytest.approx((11.5, 11.5), rel=1e-3)
    assert [abs(angle) for angle in impact.direction] == pytest.approx([math.pi, math.pi], abs=1e-6)
    assert impact.closing_speed == pytest.approx(20.0)
    assert abs(impact.impact_angle) == pytest.approx(math.pi)
    assert impact.clock == (12, 12)
    assert impact.point == pytest.approx((length / 2 + 0.25, 0.0), abs=0.06)
    assert impact.time == pytest.approx(0.025, abs=2 * SUBSTEP)


def test_a_side_impact_is_recorded_from_both_seats() -> None:
    """Struck from the right at a right angle: 3 o'clock for one, 12 for the other, pushed to the left and back."""
    struck, striking = (actor(), (0, 0, 0, 0, 0, 0)), (actor(), (0, -6, math.pi / 2, 0, 10, 0))
    (impact, *_) = Crash(struck, striking).step(400).impacts()
    assert impact.clock == (3, 12)
    assert impact.impact_angle == pytest.approx(math.pi / 2)
    assert impact.direction[0] == pytest.approx(math.pi / 2, abs=0.05)
    assert abs(impact.direction[1]) == pytest.approx(math.pi, abs=0.05)


def test_a_fixed_obstacle_stays_where_it_is() -> None:
    """What is fixed takes the impulse and no velocity."""
    wall = actor(ActorKind.OBSTACLE, fixed=1.0)
    crash = Crash((actor(), (0, 0, 0, 10, 0, 0)), (wall, (4, 0, 0, 0, 0, 0))).step(400)
    (impact, *_) = crash.impacts()
    assert impact.delta_v[1] == 0.0
    assert impact.delta_v[0] == pytest.approx(11.5, rel=1e-3)
    assert crash.bodies[1].position == (4, 0)


def test_a_light_obstacle_has_its_mass() -> None:
    """A crate of 200 kg is knocked away: what it receives the car loses."""
    car, crate = actor(), actor(ActorKind.OBSTACLE)
    crash = Crash((car, (0, 0, 0, 10, 0, 0)), (crate, (4, 0, 0, 0, 0, 0))).step(400)
    (impact, *_) = crash.impacts()
    assert crate.mass * impact.delta_v[1] == pytest.approx(car.mass * impact.delta_v[0])
    assert impact.delta_v[1] == pytest.approx(1.15 * 10 * car.mass / (car.mass + crate.mass), rel=1e-2)


@pytest.mark.parametrize("speed", [5.0, 15.0, 30.0])
def test_delta_v_of_the_pinched_is_what_happened_to_them(speed: float) -> None:
    """The impact of a bicycle between bus and wall is the change of its velocity, not what it handed on to the wall."""
    bus, bicycle = actor(ActorKind.BUS), actor(ActorKind.BICYCLE)
    wall = actor(ActorKind.OBSTACLE, fixed=1.0)
    places = (-10.0, 0.0), (0.2, 0.0), (1.7, 0.0)
    (bx, _), (cx, _), (wx, _) = places
    crash = Crash((bus, (bx, 0, 0, speed, 0, 0)), (bicycle, (cx, 0, 0, 0, 0, 0)), (wall, (wx, 0, 0, 0, 0, 0))).step(800)
    for impact in crash.impacts():
        assert max(impact.delta_v) <= 3.0 * speed


def test_an_error_in_a_callback_is_raised_after_the_step() -> None:
    """Pymunk itself would print it and go on."""
    crash = Crash((actor(), (0, 0, 0, 10, 0, 0)), (actor(), (5, 0, 0, 0, 0, 0)))
    crash.recorder._number.clear()
    with pytest.raises(KeyError):
        crash.step(100)


@pytest.mark.parametrize(("angle", "hour"), [(0, 12), (-30, 1), (-90, 3), (180, 6), (90, 9), (29, 11), (14, 12)])
def test_clock_positions(angle: float, hour: int) -> None:
    """12 straight ahead, 3 to the right, wherever the car looks."""
    heading = 2.0
    direction = heading + math.radians(angle)
    assert clock_position((1 + math.cos(direction), 2 + math.sin(direction)), (1, 2, heading)) == hour


def test_friction_stops_a_slide_in_the_known_distance() -> None:
    """With mu 1 a car that slides at 10 m/s comes to rest after v^2 / (2 mu g) and stays there."""
    sliding = actor()
    crash = Crash((sliding, (0, 0, 0.3, 0, 10, 0)))
    body = crash.bodies[0]
    crash.step(600, lambda: rub(body, sliding, SUBSTEP))
    assert body.velocity.length == 0.0
    assert math.hypot(*body.position) == pytest.approx(100 / (2 * 9.81), rel=0.01)


@given(st.floats(-20, 20), st.floats(-20, 20), st.floats(-8, 8), st.floats(-3, 3))
def test_friction_takes_energy_and_reverses_nothing(vx: float, vy: float, spin: float, heading: float) -> None:
    """Each substep has less energy than the one before, until all is still; and it gets still."""
    sliding = actor()
    body = Crash((sliding, (0, 0, heading, vx, vy, spin))).bodies[0]
    for _ in range(4000):
        before, velocity = kinetic_energy(body), body.velocity
        if rub(body, sliding, SUBSTEP):
            break
        assert kinetic_energy(body) < before
        assert (body.velocity - velocity).length <= 9.81 * SUBSTEP * (1.0 + 1e-9)
    assert kinetic_energy(body) == 0.0


def test_inertia_grows_with_mass_and_size() -> None:
    """A car of the table has the table's inertia; twice the mass has twice as much."""
    assert actor().inertia == pytest.approx(CAR.yaw_inertia)
    assert actor(mass=2 * CAR.mass).inertia == pytest.approx(2 * CAR.yaw_inertia)
    assert actor(length=9.0).inertia > actor().inertia


def test_axle_loads_add_up_to_the_weight() -> None:
    """Rear and front share the weight by their distance from the centre; a walker has two halves."""
    for kind in ActorKind:
        one = actor(kind)
        rests = one.supports
        assert rests.rear.grip + rests.front.grip == pytest.approx(9.81)
        assert rests.rear.grip * rests.rear.offset + rests.front.grip * rests.front.offset == pytest.approx(
            0.0, abs=1e-9
        )
