"""The words that the parser reads as units, and the sizes that the semantics gives them."""

from cortex_dsl.semantics.quantities.units import UNITS
from cortex_dsl.syntax.literals import SPOKEN_UNITS, UNIT_WORDS


def test_every_unit_word_has_a_size() -> None:
    """The two tables name the same units."""
    assert set(UNITS) == set(UNIT_WORDS)


def test_what_people_write_leads_to_a_unit() -> None:
    """Every spoken form stands for a unit that exists, and is none itself."""
    assert set(SPOKEN_UNITS.values()) <= set(UNIT_WORDS)
    assert not set(SPOKEN_UNITS) & set(UNIT_WORDS)
