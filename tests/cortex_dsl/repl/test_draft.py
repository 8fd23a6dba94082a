"""Drafts, their history, and how a text becomes entries."""

from pathlib import Path

import pytest

from cortex_dsl.repl.draft import Draft, History, keys, place, place_last, place_with_sources, split
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*.scn"))


def entries_of(text: str) -> tuple[str, ...]:
    source = Source("x", text)
    return split(source, parse(source))


def test_undo_and_redo() -> None:
    """What is undone comes back by redo, until something else is done."""
    first, second = Draft(("x = 1",)), Draft(("x = 1", "y = 2"))
    history = History().step(first).step(second)
    undone = history.undone()
    assert undone is not None
    assert undone.present == first
    redone = undone.redone()
    assert redone is not None
    assert redone.present == second
    assert undone.step(Draft(("z = 3",))).redone() is None
    assert History().undone() is None


def test_a_step_to_the_same_draft_is_none() -> None:
    """Entering what is there already leaves nothing to undo."""
    history = History().step(Draft(("x = 1",)))
    assert history.step(Draft(("x = 1",))) is history


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_entries_are_the_text(path: Path) -> None:
    """Splitting loses nothing: joined, the entries of a file are its text."""
    text = path.read_text()
    draft = Draft(entries_of(text))
    assert draft.text.rstrip("\n") == text.rstrip("\n")
    assert len(draft.entries) > 10


def test_comments_belong_to_what_stands_below() -> None:
    """A docstring is an entry; comments and blank lines go with the statement below, the last ones with the last."""
    text = '"""Doc\nof two lines."""\n# about x\nx = 1 # one\n\nbehavior B():\n    # inside\n    wait\n\ny = 2\n# end\n'
    assert entries_of(text) == (
        '"""Doc\nof two lines."""',
        "# about x\nx = 1 # one",
        "\nbehavior B():\n    # inside\n    wait",
        "\ny = 2\n# end",
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("param V = Range(1, 2) m/s", "param V = Range(3, 4) m/s"),
        ("param V = Range(1, 2) m/s", "V = 3 m/s"),
        ("behavior B():\n    wait", "behavior B(x):\n    wait"),
        ("class Van(Car):\n    width: 3 m", "class Van(Car):\n    width: 2 m"),
        ("map intersection(ways=4)", "map intersection(ways=3)"),
        ("terminate after 5 s", "terminate after 9 s"),
        ('require V > 1 m/s as "fast"', 'require V > 2 m/s as "fast"'),
        ("ego = new Car on road", "ego = new Truck on road"),
    ],
)
def test_the_same_thing_is_replaced_in_its_place(old: str, new: str) -> None:
    """A new definition takes the place of the old one, and comments above it stay."""
    draft = Draft(("a = 1", f"# why\n{old}", "b = 2"))
    placed = place(draft, new)
    assert placed.draft.entries == ("a = 1", f"# why\n{new}", "b = 2")
    assert placed.index == 1
    assert placed.replaced
    last = place_last(draft, new)
    assert last is not None
    assert last.draft.entries == ("a = 1", "b = 2", new)


@pytest.mark.parametrize("chunk", ["require V > 3 m/s", "a = a + 1", "b = 3", "terminate when V > 3 m/s"])
def test_other_things_are_added(chunk: str) -> None:
    """What defines nothing that is there goes to the end."""
    draft = Draft(("a = 1", "require V > 2 m/s", "terminate after 5 s"))
    assert place(draft, chunk).draft.entries == (*draft.entries, chunk)


def test_half_of_a_statement_is_not_replaced() -> None:
    """`param A = 1, B = 2` would lose B."""
    draft = Draft(("param A = 1, B = 2",))
    assert place(draft, "param A = 3").draft.entries == ("param A = 1, B = 2", "param A = 3")


def test_what_cannot_be_read_defines_nothing() -> None:
    """Keys are asked of texts that compile; others have none."""
    assert keys("param = = 3") == frozenset()


def test_the_environment_goes_above_all_objects() -> None:
    """It may come to mind last, but must be known before anybody looks."""
    draft = Draft(("param WET = Range(0, 1)", "ego = new Car on road", "other = new Car on road"))
    placed = place(draft, "environment(friction=WET)")
    assert placed.draft.entries[:2] == ("param WET = Range(0, 1)", "environment(friction=WET)")
    assert placed.index == 1
    assert place(placed.draft, "environment(sight=9 m)").replaced == "`environment`"


def test_what_a_redefined_entry_reads_moves_above_it() -> None:
    """With all that this reads in turn; whatever reads the entry stays below."""
    draft = Draft(("ego = new Car", "other = new Car ahead of ego", "U = 1", "V = U * 3 m/s", "terminate after 3 s"))
    placed = place_with_sources(draft, "ego = new Car at (0, 0), with speed V")
    assert placed is not None
    assert placed.draft.entries == (
        "U = 1",
        "V = U * 3 m/s",
        "ego = new Car at (0, 0), with speed V",
        "other = new Car ahead of ego",
        "terminate after 3 s",
    )
    assert (placed.index, placed.replaced) == (2, "`ego`")
    assert place_with_sources(draft, "ego = new Truck") is None
    assert place_with_sources(draft, "third = new Car at (0, 0), with speed V") is None
