"""`--reference`: who judges a collision, in the manifest, in documents, and on the terminal."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from engine.references import NAMES
from engine.search.journal_reader import read_journal

Command = Callable[..., Any]
CUT_IN = Path(__file__).parents[3] / "examples" / "roads" / "motorway_cut_in.scn"
SMALL = ("--random", "--generations", "3", "--population", "100", "--seed", "1")


def searched(cortexc: Command, folder: Path, *more: str) -> dict[str, Any]:
    result = cortexc(CUT_IN, *SMALL, "--out", folder, "--json", *more)
    assert result.code == 0
    (search,) = result.document["searches"]
    return search


def test_the_set_is_kept_and_each_verdict_has_its_drivers(cortexc: Command, tmp_path: Path) -> None:
    """Counts add up; what `careful` alone says is `avoidability`, whoever else judges."""
    every, alone = (
        searched(cortexc, tmp_path / "every"),
        searched(cortexc, tmp_path / "alone", "--reference", "careful"),
    )
    for found, names in ((every, list(NAMES)), (alone, ["careful"])):
        assert found["manifest"]["settings"]["search"]["references"] == names
        came = found["failures"]
        parts = ("avoidable", "disputed", "unavoidable", "no_model", "struck", "unknown")
        assert sum(came[name] for name in parts) == came["collisions"] > 0
        for case in found["cases"]:
            if case["collided"]:
                assert list(case["references"]) == names
                assert case["verdict"] == case["blame"]
                caused = case["verdict"] != "struck"
                assert (case["counterfactuals"] is not None) == caused
                answer = case["references"]["careful"]
                assert answer == ("struck" if not caused else answer)
                if caused:
                    assert (case["avoidability"]["avoidance"] == "avoidable") == (answer == "avoids")
    assert every["failures"]["disputed"] > 0 == alone["failures"]["disputed"]
    shown = cortexc("analyse", tmp_path / "every", "--budget", "0")
    assert all(name in shown.out for name in (*NAMES, "adapted speed", "disputed"))
    assert cortexc("verify", tmp_path / "alone").code == 0


def test_a_run_older_than_the_choice_was_judged_by_one_driver(cortexc: Command, tmp_path: Path) -> None:
    searched(cortexc, tmp_path / "run")
    manifest = read_journal(tmp_path / "run" / "journal.sqlite").manifest
    settings = {name: dict(table) for name, table in manifest.settings.items()}
    del settings["search"]["references"]
    assert replace(manifest, settings=settings).config.search.references == ("careful",)
    assert manifest.config.search.references == NAMES


@pytest.mark.parametrize("names", ["carefull", "careful,idm", ","])
def test_an_unknown_name_is_refused_with_all_names(cortexc: Command, names: str) -> None:
    result = cortexc(CUT_IN, *SMALL, "--reference", names)
    assert result.code == 2
    assert all(name in result.err for name in NAMES)
    assert "Traceback" not in result.err
