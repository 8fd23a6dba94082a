"""`cortexc examples` and `cortexc new`: what comes with cortexc can be had anywhere, and nothing is written over."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from cortex_dsl.syntax.formatting import format_source
from engine.paper import FILES

EXAMPLES = Path(__file__).parents[3] / "examples"
Command = Callable[..., Any]


def test_lists_all(cortexc: Command) -> None:
    """A line or two for each: the six of the paper in the order of their letters, then the others."""
    out = cortexc("examples").out
    places = [out.index(f"{name} ") for name in FILES]
    assert places == sorted(places)
    assert "A: the ego crosses a four-way intersection" in out
    document = cortexc("examples", "--json").document
    assert document["schema"] == "cortexc/examples"
    names = [each["name"] for each in document["examples"]]
    assert names[: len(FILES)] == list(FILES)
    assert sorted(names) == sorted(path.stem for path in EXAMPLES.rglob("*.scn"))


def test_prints_one(cortexc: Command) -> None:
    """As it is, by its name or its file's."""
    text = (EXAMPLES / "left_turn.scn").read_text(encoding="utf-8")
    for name in ("left_turn", "left_turn.scn", "examples/left_turn.scn"):
        assert cortexc("examples", name).out == text


def test_copies_them(cortexc: Command, tmp_path: Path) -> None:
    """All, or one; byte for byte."""
    assert cortexc("examples", "--copy", tmp_path / "a" / "b").code == 0
    copied = {path.name: path.read_bytes() for path in (tmp_path / "a" / "b").iterdir()}
    suffixes = (".scn", ".xodr", ".py", ".c")
    assert copied == {path.name: path.read_bytes() for path in EXAMPLES.rglob("*") if path.suffix in suffixes}
    assert cortexc("examples", "three_way_left", "--copy", tmp_path / "c").code == 0
    assert [path.name for path in (tmp_path / "c").iterdir()] == ["three_way_left.scn"]


@pytest.mark.parametrize("name", [path.stem for path in sorted(EXAMPLES.rglob("*.scn"))])
def test_a_copy_compiles_where_it_lies(name: str, cortexc: Command, tmp_path: Path) -> None:
    """It brings the files that it needs beside it, and no others."""
    assert cortexc("examples", name, "--copy", tmp_path).code == 0
    done = cortexc(tmp_path / f"{name}.scn", "--check")
    with_map = name in ("on_ramp", "ramp_with_acc", "village")
    assert (done.code, done.err) == (0, "")
    assert len(list(tmp_path.glob("*.xodr"))) == with_map


def test_a_file_that_comes_with_cortexc(cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A path of the documents that is not there is answered with the command that puts it there."""
    monkeypatch.chdir(tmp_path)
    done = cortexc("examples/left_turn.scn", "--check")
    assert done.code == 2
    assert "help: it comes with cortexc: `cortexc examples left_turn --copy examples` writes it" in done.said
    assert cortexc("examples", "left_turn", "--copy", "examples").code == 0
    assert cortexc("examples/left_turn.scn", "--check").code == 0


def test_copies_over_nothing(cortexc: Command, tmp_path: Path) -> None:
    """One file that is there stops all."""
    mine = tmp_path / "three_way_left.scn"
    mine.write_text("mine")
    done = cortexc("examples", "--copy", tmp_path)
    assert (done.code, mine.read_text(), len(list(tmp_path.iterdir()))) == (2, "mine", 1)
    assert "is there already" in done.said


def test_an_unknown_example(cortexc: Command) -> None:
    """The nearest one is named."""
    done = cortexc("examples", "lft_turn")
    assert done.code == 2
    assert "did you mean `left_turn`?" in done.said


def test_new_begins_a_scenario(cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It compiles without a word, is laid out as by `fmt`, and runs as it is."""
    monkeypatch.chdir(tmp_path)
    assert cortexc("new", "first").code == 0
    text = Path("first.scn").read_text(encoding="utf-8")
    source = Source("first.scn", text)
    assert not compile_source(source).diagnostics
    assert format_source(source) == text
    assert cortexc("first.scn", "--json").document["verdict"] == "valid"


def test_what_is_shown_can_be_typed(cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that looks like an option, or that a shell would take apart, is shown as it has to be written."""
    monkeypatch.chdir(tmp_path)
    assert "`cortexc ./-x.scn` runs it" in cortexc("new", "./-x.scn").out
    assert "`cortexc 'a b.scn'` runs it" in cortexc("new", "a b.scn").out
    assert "cortexc ./-x.scn --seed 0" in cortexc("./-x.scn").out
    found = cortexc("a b.scn", "--random", "--generations", 1, "--out", "./-o p").out
    assert "cortexc report './-o p' --open" in found
    assert "cortexc resume './-o p' --metrics" in found


def test_new_writes_over_nothing(cortexc: Command, tmp_path: Path) -> None:
    """Not over a file, and not over a link that leads nowhere."""
    there, link = tmp_path / "there.scn", tmp_path / "link.scn"
    there.write_text("mine")
    link.symlink_to(tmp_path / "nothing.scn")
    for path in (there, there.with_suffix(""), link):
        assert cortexc("new", path).code == 2
    assert there.read_text() == "mine"
    assert not (tmp_path / "nothing.scn").exists()


@pytest.mark.parametrize("words", [(), (".",), ("/",), ("nowhere/first.scn",)])
def test_new_needs_a_name(
    words: tuple[str, ...], cortexc: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a file in a folder that is there."""
    monkeypatch.chdir(tmp_path)
    done = cortexc("new", *words)
    assert done.code == 2
    assert "help: " in done.said or "no such file" in done.said
    assert not list(tmp_path.iterdir())
