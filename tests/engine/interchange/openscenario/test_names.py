"""Names that every reader takes."""

import re

from hypothesis import given
from hypothesis import strategies as st

from engine.interchange.openscenario.document import literal, plain_name, unique_names


@given(st.lists(st.text(max_size=6)))
def test_names_are_unique_and_plain(texts: list[str]) -> None:
    """Whatever they were, no two are the same, and each is an identifier."""
    names = unique_names(texts)
    assert len(names) == len(texts)
    assert len(set(names)) == len(names)
    assert all(re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) for name in names)


def test_names_are_still_to_be_recognised() -> None:
    """Marks fall away, signs and spaces become underscores, a number sets those apart that become the same."""
    texts = ["ego", "Café 3", "a::b", "a b", "$speed", "2nd", "道"]
    assert unique_names(texts) == ("ego", "Cafe_3", "a_b", "a_b_2", "speed", "_2nd", "unnamed")


@given(st.from_regex(r"[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*", fullmatch=True))
def test_a_plain_name_stays(name: str) -> None:
    """What is an identifier already is not touched."""
    assert plain_name(name) == name


def test_a_number_that_is_taken_is_passed_over() -> None:
    """A name made unique never takes that of another."""
    assert unique_names(["car_2", "car", "car"]) == ("car_2", "car", "car_3")


def test_no_text_refers_to_a_parameter() -> None:
    """A dollar sign anywhere would be read as a reference."""
    assert "$" not in literal("cost $5 of ${all}")
