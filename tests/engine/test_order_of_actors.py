"""The order of the actors in a file changes neither what is measured of a pair nor which pair a scene is judged by."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

import cortex_dsl as cx
from engine.outcomes import MEASURED, Per
from tests.laws import examples

HEAD = """map road(length=400 m, lanes=3)
ego = new Car at (0, -150), facing 0 deg, with speed 15 m/s, with regionContainedIn None
"""
FASTEST = {"Car": 8.0, "Truck": 8.0, "Pedestrian": 1.0, "Obstacle": 0.0, "Trash": 0.0}
"""Classes of actors and props, each with its highest speed [m/s]."""
ACTOR = st.tuples(
    st.sampled_from(tuple(FASTEST)),
    st.sampled_from((-9.0, -6.0, -4.5, 4.5, 6.0, 9.0)),
    st.integers(-14, 10).map(lambda step: 10.0 * step),
    st.sampled_from((0.0, 1.0, 8.0)),
)


def text(actors: list[tuple[str, float, float, float]], order: list[int]) -> str:
    """A scenario whose actors stand in this order, each with a name of its own."""
    lines = [
        f"actor_{number} = new {kind} at ({across}, {along}), facing 0 deg, "
        f"with speed {min(speed, FASTEST[kind])} m/s, "
        "with regionContainedIn None, with allowCollisions True"
        for number, (kind, across, along, speed) in ((number, actors[number]) for number in order)
    ]
    return HEAD + "\n".join(lines) + "\nterminate after 8 s\n"


@examples(25)
@given(st.lists(ACTOR, min_size=1, max_size=4, unique_by=lambda each: each[1:3]), st.data())
def test_the_order_of_actors(actors: list[tuple[str, float, float, float]], data: st.DataObject) -> None:
    """Every metric of a pair, and the deciding pair, of two to five actors and props, many with the same bands."""
    order = data.draw(st.permutations(range(len(actors))))
    found = []
    for numbers in (list(range(len(actors))), list(order)):
        scenario = cx.compile_text(text(actors, numbers))
        scenes = scenario.sample(1, seed=1)
        assert scenes.valid[0]
        outcomes = scenario.simulate(scenes)
        names = scenario.program.actors[1:]
        pairs = {
            row.name: dict(zip(names, getattr(outcomes, row.name)[0].tolist(), strict=True))
            for row in MEASURED
            if row.per is Per.PAIR and not row.parts
        }
        risk = scenario.assess(outcomes)
        pair = int(risk.pair[0])
        found.append((pairs, risk.score[0], risk.continuous[0], names[pair] if pair >= 0 else ""))
    (before, *judged), (after, *again) = found
    for name, values in before.items():
        for actor, value in values.items():
            np.testing.assert_equal(after[name][actor], value, err_msg=f"{name} of {actor}")
    assert judged == again
