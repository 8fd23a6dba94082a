"""Stream keys: their ranges, their text, and that no two addresses meet."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from engine.kernels.random_numbers import fill_uniform
from engine.streams import (
    FIELD_BITS,
    StreamKey,
    check_keys,
    format_key,
    format_keys,
    key_rows,
    method_number,
    old_number,
    operator_generator,
    parse_key,
)
from engine.vocabulary import Method, Purpose

keys = st.builds(
    StreamKey,
    seed=st.integers(0, (1 << 63) - 1),
    method=st.sampled_from([int(method) for method in Method]) | st.text(min_size=1).map(method_number),
    run=st.integers(0, (1 << 16) - 1),
    generation=st.integers(0, (1 << 16) - 1),
    index=st.integers(0, (1 << 32) - 1),
    rollout=st.integers(0, (1 << 16) - 1),
)


new_names = st.text().filter(lambda name: old_number(name) == Method.CUSTOM)


@given(keys)
def test_text_round_trip(key):
    """A key written into a concrete file is read back as it was."""
    assert parse_key(format_key(key)) == key
    assert format_keys(np.array([key, key], dtype=np.int64)) == [format_key(key)] * 2


def test_text_of_a_key():
    """The text is stable: concrete files hold it."""
    assert format_key(StreamKey(1, Method.GA, 0, 12, 55, 0)) == "1.ga.0.12.55.0"


def test_text_of_a_key_of_a_method_without_a_value():
    """It names the method by the hash of its name, which is stable too; and every other number is refused."""
    assert format_key(StreamKey(1, method_number("climber"), 0, 12, 55, 0)) == "1.method-1fd94f4f.0.12.55.0"
    for stray in (16, 16 << 4):
        with pytest.raises(ValueError, match="the number of no method"):
            format_key(StreamKey(1, stray, 0, 12, 55, 0))


def test_numbers_of_methods():
    """Those of `Method` stay what they were; others follow from the name, whatever it is."""
    assert [method_number(name) for name in ("random", "ga", "niching")] == [2, 3, 14]
    names = ["climber", "Climber", "climber2", "single", "sample", "custom", "GA", ""]
    numbers = {method_number(name) for name in names}
    assert len(numbers) == len(names)
    assert all(number & 15 == Method.CUSTOM and 15 < number < 1 << FIELD_BITS.method for number in numbers)
    assert {old_number(name) for name in names} == {Method.CUSTOM}


@given(st.lists(new_names, min_size=2, max_size=2, unique=True), st.integers(0, (1 << 63) - 1))
def test_names_have_streams_of_their_own(names, seed):
    """In scenes and in operators, and no method of the vocabulary has those of a name."""
    methods = [*map(method_number, names), Method.CUSTOM, Method.GA]
    scenes = np.empty((len(methods), 4))
    keys = np.concatenate([key_rows(seed, method, 1, 2, [3]) for method in methods])
    fill_uniform(keys, int(Purpose.SCENE), 0, scenes)
    operators = np.array([operator_generator(seed, method, 1, 2, 3).random(4) for method in methods])
    for numbers in (scenes, operators):
        assert len(np.unique(numbers)) == numbers.size


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("1.ga.0.12.55", "six fields"),
        ("1.genetic.0.12.55.0", "valid: single, sample, random, ga"),
        ("1.method-12.0.12.55.0", "`method-12` is not a method"),
        ("1.ga.0.twelve.55.0", "generation of a stream key is a whole number"),
        ("1.ga.-1.12.55.0", "run of a stream key"),
        ("1.ga.0.70000.55.0", "generation of a random stream is 70000; it must lie in 0 .. 65535"),
        ("", "six fields"),
    ],
)
def test_bad_text_is_explained(text, complaint):
    """What is no key is refused with the field at fault."""
    with pytest.raises(ValueError, match=complaint):
        parse_key(text)


def test_rows():
    """One row an index, in the order of StreamKey."""
    rows = key_rows(9, Method.RANDOM, 1, 2, [30, 40], rollout=5)
    assert rows.dtype == np.int64
    assert rows.tolist() == [[9, 2, 1, 2, 30, 5], [9, 2, 1, 2, 40, 5]]
    assert key_rows(9, Method.RANDOM, 1, 2, []).shape == (0, 6)


@pytest.mark.parametrize("field", StreamKey._fields)
def test_values_beyond_a_field_are_refused(field):
    """A value that would spill into another field's bits is an error, at both ends."""
    for value in (-1, 1 << getattr(FIELD_BITS, field)):
        fields = {**StreamKey(0, 0, 0, 0, 0, 0)._asdict(), field: value}
        with pytest.raises((ValueError, OverflowError)):
            key_rows(
                fields["seed"],
                fields["method"],
                fields["run"],
                fields["generation"],
                [fields["index"]],
                fields["rollout"],
            )


def test_arrays_of_another_shape_or_type_are_refused():
    """The message names what was expected and what came."""
    with pytest.raises(ValueError, match=r"expected \(n, 6\) int64 stream keys, got \(2, 5\) int64"):
        check_keys(np.zeros((2, 5), dtype=np.int64))
    with pytest.raises(ValueError, match="int32"):
        check_keys(np.zeros((2, 6), dtype=np.int32))


@given(st.lists(keys.map(lambda key: key._replace(rollout=0)), min_size=2, max_size=2, unique=True))
def test_operator_streams_differ(pair):
    """Two addresses never give the same operator numbers; one address always does."""
    first, second = (operator_generator(*key[:5]).random(4) for key in pair)
    assert not np.array_equal(first, second)
    assert np.array_equal(first, operator_generator(*pair[0][:5]).random(4))
