"""`make validate` as far as it goes without the checkers: what it asks for, and that it can find something."""

from pathlib import Path

import pytest

from benchmarks.validation import environments, material
from benchmarks.validation.checks import CHECKERS, CHECKS, Check, Verdict, judged
from benchmarks.validation.encounters import encounters
from benchmarks.validation.environments import REQUIREMENTS, SetupError, set_up
from benchmarks.validation.items import Item
from benchmarks.validation.looks import looked
from benchmarks.validation.material import EXAMPLES, cases, written
from benchmarks.validation.roads import counted, specs
from benchmarks.validation.samples import SCRIPTS, sampled
from benchmarks.validation.table import BEGIN, END, markdown, write
from engine.maps import RoadSpec

OURS = next(check for check in CHECKS if not check.checker)


@pytest.fixture(scope="module")
def items(tmp_path_factory: pytest.TempPathFactory) -> list[Item]:
    """A scene without contact, written in every way."""
    folder = tmp_path_factory.mktemp("validation")
    found = cases(EXAMPLES[0], folder / "run", top=0, others=1)
    samples = sampled(folder / "samples", 5, {name: SCRIPTS[name] for name in ("ranges", "regions")})
    return [
        *written(found, folder / "files"),
        *looked(folder / "looks", 5),
        *encounters(folder / "encounters"),
        *samples,
    ]


def test_every_check_has_what_it_needs() -> None:
    """A script, and requirements for its environment, each with its version."""
    for check in CHECKS:
        if check.checker:
            assert (CHECKERS / f"ask_{check.checker}.py").exists()
            assert "==" in (REQUIREMENTS / f"{check.checker}.txt").read_text(encoding="utf-8")


def test_the_sweep_has_every_kind_of_road() -> None:
    """Ways, lanes, corners that are none, grids, both hands; what a checker must count follows from our network."""
    every = list(specs())
    for field, values in {"ways": {3, 4}, "lanes": {1, 2, 3, 4}, "left_hand": {False, True}}.items():
        assert {getattr(spec, field) for spec in every} == values
    assert min(spec.corner_radius for spec in every) == 0.0
    assert max(spec.rows * spec.cols for spec in every) == 16
    assert counted(RoadSpec(ways=4)) == {"through": [12], "turns": [1] * 12, "left_hand": False}


def test_a_case_is_held_against_every_check(items: list[Item]) -> None:
    """In all versions and formats, and none of them refused."""
    assert {kind for check in CHECKS for kind in check.kinds} <= {item.kind for item in items}
    assert not [item.problem for item in items if item.problem]
    assert {item.version for item in items if item.kind == "replay"} == {"1.0", "1.1", "1.2", "1.3"}


def test_the_round_trip_passes_and_a_spoilt_file_does_not(items: list[Item]) -> None:
    """Spoilt ones that pass would be findings; so is a file that says something else than its case."""
    verdicts = judged(OURS, items)
    assert [verdict.kind for verdict in verdicts] == list(OURS.kinds)
    assert not any(verdict.findings for verdict in verdicts)
    blind = Check("", "blind", "nothing", ("replay",), ("cortexc", "cortexc"))
    (verdict,) = judged(blind, items)
    assert list(verdict.findings.values()) == [["passes, and was spoilt on purpose"]]


def test_a_refused_case_is_a_finding(items: list[Item]) -> None:
    """It counts as a file, and is reported with its reason."""
    refused = Item("csv", Path("none.csv"), problem="a format cannot carry it")
    verdict = next(each for each in judged(OURS, [*items, refused]) if each.kind == "csv")
    assert verdict.findings == {"none.csv": ["a format cannot carry it"]}


def test_without_a_network_it_says_what_it_takes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One sentence instead of a traceback, and nothing that looks installed."""
    monkeypatch.setattr(environments, "FOLDER", tmp_path)
    with pytest.raises(SetupError, match="name a Python"):
        set_up(["opendrive"], str(tmp_path / "no-python"), lambda _: None)
    with pytest.raises(SetupError, match="it takes a network"):
        set_up(["opendrive"], "false", lambda _: None)
    assert not (tmp_path / "opendrive" / "installed.txt").exists()


def test_the_table_goes_between_its_markers(tmp_path: Path) -> None:
    """And nowhere else; a page without markers is left alone."""
    page = tmp_path / "page.md"
    page.write_text(f"before\n{BEGIN}\nold\n{END}\nafter\n", encoding="utf-8")
    text = markdown([Verdict(OURS, "replay", ("1.0", "1.3"), 8, {"a": ["one", "two"]})])
    write(page, text)
    assert text.endswith("| our own reader | replay, 1.0 to 1.3 | metrics to 1e-6 and the risk as they were | 8 | 2 |")
    assert page.read_text(encoding="utf-8") == f"before\n{BEGIN}\n{text}\n{END}\nafter\n"
    page.write_text("nothing\n", encoding="utf-8")
    with pytest.raises(ValueError, match="no markers"):
        write(page, text)


def test_the_examples_are_those_of_the_paper() -> None:
    """A to F, and beside them scenarios of other constructs."""
    assert len(EXAMPLES) == 6
    assert len(material.CONSTRUCTS) >= 7
