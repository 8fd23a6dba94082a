"""A campaign of `benchmarks.torture` that was stopped goes on, and ends as if it had not been."""

from pathlib import Path

import pytest

from benchmarks.torture import kills, texts
from benchmarks.torture.ledger import Ledger


def test_a_line_that_was_not_written_to_its_end_is_done_again(tmp_path: Path) -> None:
    """What stands before it is kept, and what comes after it is readable."""
    path = tmp_path / "kept" / "texts.jsonl"
    Ledger.of(path).add("one", {"compiled": 1})
    path.write_bytes(path.read_bytes() + b'{"piece": "two", "res')
    ledger = Ledger.of(path)
    assert ledger.done == {"one": {"compiled": 1}}
    ledger.add("three", {"compiled": 3})
    assert Ledger.of(path).done == {"one": {"compiled": 1}, "three": {"compiled": 3}}


def test_what_is_kept_is_not_judged_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two chunks one is known; texts that break something count in both, and those of the other are written down."""
    first, second = texts.chunks(150, 10, seed=4)
    assert (first.runs, second.texts, second.runs) == (7, 50, 4)
    ledger = Ledger.of(tmp_path / "texts.jsonl")
    ledger.add(first.name, {"compiled": 90, "broken": 10})
    broken = texts.Part(texts.Counter({"compiled": 49, "broken": 1}), [texts.fuzz.Broken("bytes-KeyError", b"x", "t")])
    monkeypatch.setattr(texts, "_spread", lambda asked, _: [(chunk, broken) for chunk in asked])
    found = texts.judged(150, 10, 4, 1, ledger, tmp_path)
    assert found == {"compiled": 139, "broken": 11}
    assert (tmp_path / f"broken-{second.name}" / "0000-bytes-KeyError.scn").read_bytes() == b"x"
    assert texts.judged(150, 10, 4, 1, Ledger.of(tmp_path / "texts.jsonl"), None) == found


def test_kills_go_on_with_the_round_that_is_lacking(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And what was found wrong before stays found."""
    asked: list[tuple[str, int]] = []

    def count(kind: str, _: object, number: int) -> dict[str, object]:
        asked.append((kind, number))
        return {"kills": number, "wrong": ["is another"] * (kind == "fmt")}

    monkeypatch.setattr(kills, "_round", count)
    ledger = Ledger.of(tmp_path / "kills.jsonl")
    kills.killed(14, 0, ("fmt",), ledger)
    assert asked == [("fmt", 12), ("fmt", 2)]
    assert kills.killed(14, 0, ("fmt",), Ledger.of(tmp_path / "kills.jsonl")) == ({"fmt": 14}, ["fmt: is another"] * 2)
    assert len(asked) == 2
