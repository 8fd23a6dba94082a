"""What is written into properties reads back, and what is broken in them is not believed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from engine.interchange import own_metadata
from engine.interchange.recording import Recording
from engine.vocabulary import ActorKind, State
from tests.engine.interchange.openscenario.conftest import actor, recordings, small


@given(recordings())
def test_samples_read_back(of: Recording) -> None:
    """To the bit, for everybody who is there at some time."""
    rng = np.random.default_rng(len(of))
    of.states[:, :, State.SPEED : State.PRESENT] = rng.normal(size=of.states[:, :, State.SPEED : State.PRESENT].shape)
    for index in range(len(of.actors)):
        there, read = of.there[:, index], own_metadata.samples_in(own_metadata.of_samples(of, index))
        assert (read is not None) == bool(there.any())
        if read is not None:
            assert read.time.tolist() == of.time[there].tolist()
            assert {state: values.tolist() for state, values in read.columns.items()} == {
                state: of.states[there, index, state].tolist()
                for state in (*own_metadata.MOTION, *own_metadata.COMMANDS)
            }


@pytest.mark.parametrize("kind", ActorKind)
def test_fields_read_back(kind: ActorKind) -> None:
    """An infinite top speed among them."""
    one = replace(actor("one", kind), max_speed=math.inf)
    said = own_metadata.of_actor(one, own_metadata.FIELDS)
    assert own_metadata.kind_in(said) is kind
    assert said[own_metadata.NAME] == "one"
    assert own_metadata.fields_in(said) == {field: getattr(one, field) for field in own_metadata.FIELDS}


def test_motion_alone_reads_back_without_commands() -> None:
    read = own_metadata.samples_in(own_metadata.of_samples(replace(small(), commands=False), 0))
    assert read is not None
    assert set(read.columns) == set(own_metadata.MOTION)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        (own_metadata.TIME, ""),
        (own_metadata.TIME, "0 0.05 0.05 0.12 0.15"),
        ("cortexc.speed", "1 2 3"),
        ("cortexc.speed", "1 2 3 nan 5"),
        ("cortexc.speed", "1 2 3 1_000 5"),
        ("cortexc.speed", "1 2 3 1e300 5"),
        ("cortexc.steer", "left"),
        ("cortexc.present", "1 2 3 1 1"),
    ],
)
def test_broken_samples_are_not_believed(name: str, text: str) -> None:
    """Missing, not of one length, out of order, or no numbers of a file."""
    assert own_metadata.samples_in({**own_metadata.of_samples(small(), 0), name: text}) is None


@pytest.mark.parametrize("text", ["", "0", "-0.05", "1e10", "soon"])
def test_a_step_that_is_none(text: str) -> None:
    assert own_metadata.step_in({own_metadata.STEP: text}) is None
    assert own_metadata.step_in({own_metadata.STEP: "0.05"}) == 0.05
