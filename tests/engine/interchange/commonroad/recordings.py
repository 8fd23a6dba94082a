"""Recordings made by hand: whoever takes part drives along the first lanes of a road at 5 m/s."""

from dataclasses import replace

import numpy as np

from engine.interchange import Contact, Provenance, RecordedActor, Recording, SignalTimes
from engine.maps import MapSpec, RoadSpec
from engine.road import build_network
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, State

STEP = 0.1
SPEED = 5.0
ROAD = RoadSpec(approach=20.0)
LIGHTS = SignalTimes(green=10.0, yellow=3.0, all_red=2.0, offset=4.0)
ORIGIN = Provenance(
    title="a car meets <another>",
    date="2025-03-01T12:00:00",
    facts={"scenario": "two & two.scn", "seed": "7"},
    genome={"SPEED": "18 km/h"},
)


def actor(name: str, kind: ActorKind = ActorKind.CAR) -> RecordedActor:
    model = MODELS[kind]
    return RecordedActor(
        name=name,
        kind=kind,
        length=model.length,
        width=model.width,
        rear_to_center=model.rear_to_center,
        wheelbase=model.wheelbase,
        mass=model.mass,
        max_acceleration=model.max_acceleration,
        max_braking=model.max_braking,
        max_steer=model.max_steer,
        max_speed=model.top_speed,
    )


def recording(
    *kinds: ActorKind, samples: int = 4, road: MapSpec = ROAD, signals: SignalTimes | None = None
) -> Recording:
    """The ego, a car, and one more of each kind; obstacles stand."""
    network, kinds = build_network(road), (ActorKind.CAR, *kinds)
    states = np.zeros((samples, len(kinds), len(State)))
    for index, kind in enumerate(kinds):
        lane = network.lanes[index % len(network.lanes)]
        speed = 0.0 if kind is ActorKind.OBSTACLE else SPEED
        for sample in range(samples):
            pose = network.paths.pose(lane.path, 5.0 + speed * STEP * sample)
            states[sample, index, [State.X, State.Y, State.HEADING, State.SPEED, State.PRESENT]] = [*pose, speed, 1.0]
    names = ["ego", *(f"{kind.name.lower()}_{i}" for i, kind in enumerate(kinds[1:], 1))]
    return Recording(
        name="two_cars",
        actors=tuple(map(actor, names, kinds)),
        time=np.arange(samples, dtype=np.float64) * STEP,
        states=states,
        step=STEP,
        road=road,
        signals=signals,
        provenance=ORIGIN,
    )


def absent(base: Recording, index: int, *samples: int) -> Recording:
    """The same, but an actor is not there at some samples."""
    states = base.states.copy()
    states[list(samples), index, State.PRESENT] = 0.0
    return replace(base, states=states)


def crash() -> Recording:
    """Head-on at 5 m/s each: outlines touch 0.23 s into the run, and physics has both back where they came from."""
    base = recording(ActorKind.CAR, samples=6)
    gap, length = 2.3, base.actors[0].length
    states, time = base.states.copy(), base.time
    for index, side in enumerate((-1.0, 1.0)):
        ahead = np.minimum(SPEED * time, 0.5 * gap - 0.5 * SPEED * (time - 0.5 * gap / SPEED))
        states[:, index, State.X] = side * (0.5 * (gap + length) - ahead)
        states[:, index, State.Y] = -2.0
        states[:, index, State.HEADING] = 0.0 if index == 0 else np.pi
    touching = states[2].copy()
    touching[:, State.X] = [-0.5 * length, 0.5 * length]
    return replace(
        base,
        time=np.insert(time, 3, 0.23),
        states=np.insert(states, 3, touching, axis=0),
        contact=Contact(0.23, (0, 1)),
    )
