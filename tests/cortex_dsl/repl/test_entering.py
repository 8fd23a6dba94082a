"""Entries: what is added, replaced, refused, and what is merely still to come."""

from pathlib import Path

import pytest

from cortex_dsl.repl import draft as drafts
from cortex_dsl.syntax import parse

from .conftest import LEFT_TURN, Talk


def test_an_incomplete_scenario_is_no_error(talk: Talk) -> None:
    """Without an ego nothing is wrong yet; commands that need one say what is still to come."""
    said = talk("param V = Range(1, 9) m/s", "lane = Uniform(*intersection.incomingLanes)")
    assert (said.out, said.err) == ("", "")
    assert not talk.state.mistakes
    assert "still to come: an ego" in talk(":check").out
    assert "still to come: an ego" in talk(":scene").err


def test_a_mistake_is_reported_and_not_added(talk: Talk) -> None:
    """The line number is that of the listing; the draft stays as it was."""
    talk("param V = Range(1, 9) m/s")
    said = talk("require V > 3 m")
    assert "session:2:" in said.err
    assert "error[SCN" in said.err
    assert talk.text == "param V = Range(1, 9) m/s\n"
    said = talk("require V >")
    assert "session:2:" in said.err
    assert talk.state.mistakes == 2


def test_a_definition_is_replaced(talk: Talk) -> None:
    """It is said, and undo brings the old one back."""
    said = talk("param V = Range(1, 9) m/s", "x = V * 2", "param V = Range(1, 5) m/s")
    assert "replaced `V`" in said.out
    assert talk.text == "param V = Range(1, 5) m/s\nx = V * 2\n"
    said = talk(":undo")
    assert talk.text == "param V = Range(1, 9) m/s\nx = V * 2\n"
    assert "without `param V = Range(1, 5) m/s` and with `param V = Range(1, 9) m/s`" in said.out
    talk(":redo")
    assert "Range(1, 5)" in talk.text
    assert "nothing to redo" in talk(":redo").err


def test_a_definition_that_uses_later_names_moves_down(talk: Talk) -> None:
    """In its old place it would not compile; at the end it does."""
    talk("x = 1 m", "y = 2 m", "x = y * 2")
    assert talk.text == "y = 2 m\nx = y * 2\n"


def test_a_replacement_that_breaks_others_is_refused(talk: Talk) -> None:
    """What other entries need stays."""
    talk("param V = Range(1, 9) m/s", "x = V + 1 m/s")
    said = talk("param V = Range(1, 9) m")
    assert "error[SCN" in said.err
    assert "Range(1, 9) m/s" in talk.text


def test_edit_and_delete(talk: Talk) -> None:
    """The next entry takes the place of the one that is edited; one that others need cannot be deleted."""
    talk("x = 1 m", "y = x * 2", ":edit 1", "x = 5 m")
    assert talk.text == "x = 5 m\ny = x * 2\n"
    assert "SCN201" in talk(":delete 1").err
    talk(":delete 2", ":delete 1")
    assert talk.text == ""
    assert "there are no entries" in talk(":edit 1").err


def test_expressions_are_shown_and_not_added(talk: Talk) -> None:
    """Kind, unit and range; a mistake in one is reported like any other."""
    said = talk("param V = Range(18, 36) km/h", "V * 2", "(V)", "intersection.incomingLanes")
    assert "a speed, 10 to 20 m/s" in said.out
    assert "a list of 4: a lane each" in said.out
    assert talk.text == "param V = Range(18, 36) km/h\n"
    assert "did you mean `V`" in talk("v + 1").err or talk.state.mistakes


def test_a_pasted_file_is_many_entries(talk: Talk) -> None:
    """Each statement can be edited alone afterwards."""
    talk(LEFT_TURN.read_text())
    assert len(talk.state.draft.entries) > 20
    assert talk.state.checked.compiled is not None


def test_a_file_with_mistakes_can_be_mended(talk: Talk, tmp_path: Path) -> None:
    """It is loaded with its errors, and entries that add none are taken."""
    path = tmp_path / "bad.scn"
    path.write_text("ego = new Car on road,\n    with speed SPED\nx = NOPE\n")
    said = talk(f":load {path}")
    assert said.err.count("error[SCN201]") == 2
    talk("y = 1 m", ":edit 1", "ego = new Car on road,\n    with speed 3 m/s", "x = 3 m")
    assert not talk.state.checked.errors
    assert talk.state.checked.compiled is not None


def test_a_file_is_saved_formatted_and_guarded(talk: Talk, tmp_path: Path) -> None:
    """Saving writes the one layout; over another file only when confirmed."""
    path = tmp_path / "mine.scn"
    said = talk("x=1 m", f":save {tmp_path / 'mine'}")
    assert path.read_text() == "x = 1 m\n"
    assert "saved" in said.out
    assert not talk.state.unsaved
    other = tmp_path / "other.scn"
    other.write_text("y = 2\n")
    said = talk(f":save {other}")
    assert "is another file" in said.err
    assert other.read_text() == "y = 2\n"
    path.write_text("changed = 1\n")
    assert "has been changed" in talk("z = 3 m", ":save").err
    talk(":save!")
    assert path.read_text() == "x = 1 m\nz = 3 m\n"
    assert "cannot write" in talk(f":save {tmp_path / 'no' / 'folder.scn'}").err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.scn", "other.scn"]


def test_commands_that_do_not_exist(talk: Talk) -> None:
    """The nearest one is named."""
    assert "did you mean `:list`" in talk(":lits").err
    assert "takes no argument" in talk(":undo 3").err
    assert "whole number" in talk(":sample many").err
    assert talk.state.mistakes == 3


def test_held_params(talk: Talk) -> None:
    """`:set` holds, refuses what is wrong, and lets go."""
    talk("param V = Range(1, 9) m/s", "ego = new Car on road, with speed V")
    refused = talk(":set V=3 kg").err
    assert "error[SCN" in refused
    assert refused.endswith("refused: nothing was changed\n")
    talk(":set V=3 m/s")
    assert talk.state.checked.compiled is not None
    assert not talk.state.checked.compiled.program.space.names
    assert "V = 3 m/s" in talk(":set").out
    talk(":set V")
    assert not talk.state.overrides


def test_what_a_name_is(talk: Talk) -> None:
    """Own names, builtins, units and constructs."""
    said = talk("param V = Range(18, 36) km/h", ":show V", ":show SetBrakeAction", ":show km/h", ":show require")
    assert "18 to 36 km/h" in said.out
    assert "SetBrakeAction" in said.out
    assert "also `m/s`" in said.out
    assert "did you mean" in talk(":show SetBrakAction").err


def test_editing_ends_with_another_command(talk: Talk) -> None:
    """`:edit` is about the very next entry."""
    talk("x = 1 m", "y = 2 m", ":edit 1", ":seed", "z = 3 m")
    assert talk.text == "x = 1 m\ny = 2 m\nz = 3 m\n"


def test_a_refused_edit_stays_one(talk: Talk) -> None:
    """At a terminal the entry comes back by arrow up, and still goes where it was meant to."""
    talk.state.interactive = True
    talk("x = 1 m", "y = 2 m", ":edit 1", "z = 1 m +", "z = 1 m")
    assert talk.text == "z = 1 m\ny = 2 m\n"


def test_somebody_is_asked(talk: Talk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Before another file is written over and before work is dropped; no answer is a no."""
    talk.state.interactive = True
    other = tmp_path / "other.scn"
    other.write_text("y = 2\n")
    questions: list[str] = []

    def no_answer(question: str) -> str:
        questions.append(question)
        raise EOFError

    monkeypatch.setattr("builtins.input", no_answer)
    talk("x = 1 m", f":save {other}", f":load {other}")
    assert len(questions) == 2
    assert (talk.text, other.read_text()) == ("x = 1 m\n", "y = 2\n")
    monkeypatch.setattr("builtins.input", lambda _question: "y")
    talk(f":load {other}")
    assert talk.text == "y = 2\n"
    assert "nothing to undo" in talk(":undo").err


def test_an_expression_is_shown_as_it_was_typed(talk: Talk) -> None:
    """The mistake stands in the line that the user sees, and a value also in the unit of the params that it reads."""
    said = talk("x = 1 m", "foo.bar")
    assert "session:2:1: error[SCN201]" in said.err
    assert "2 | foo.bar\n  | ^^^\n" in said.err
    said = talk("y + (x")
    assert "it = " not in said.err
    said = talk("param V = Range(18, 36) km/h", "V * 2")
    assert "a speed, 10 to 20 m/s (36 to 72 km/h)" in said.out


def test_thousands_of_lines_are_pasted(talk: Talk, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is parsed a few times and no more, however many there are."""
    read: list[int] = []
    monkeypatch.setattr(drafts, "parse", lambda source: (read.append(1), parse(source))[1])
    talk("\n".join(f"x{i} = {i} m" for i in range(1500)))
    assert len(talk.state.draft.entries) == 1500
    assert len(read) < 2 * 1500
