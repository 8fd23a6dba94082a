"""A searcher of another package: found by its entry point, held to the protocol, and resumed like our own."""

import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.assessment import Evaluate
from engine.config import Config, SearchConfig
from engine.program import ParamSpace
from engine.search.journal import Journal
from engine.search.journal_reader import read_journal
from engine.search.manifest import Manifest
from engine.search.protocol import Box
from engine.search.run import Past, Task, run_campaign
from engine.search.searchers import (
    PluginError,
    UnknownMethodError,
    build_searcher,
    canonical,
    distribution_of,
    find_searcher,
    known_searchers,
    plugins,
)
from engine.streams import method_number
from engine.vocabulary import Method

CONFIG = SearchConfig(generations=4, population=6, seed=5, probes=0)
HILL_CLIMBER = '''
from engine.search.protocol import Birth, Operator, Proposal

class HillClimber:
    """Steps from the best so far; invalid and failed individuals are never the best."""
    def __init__(self, box, population, streams):
        self.box, self.population, self.streams = box, population, streams
        self.generation, self.best = -1, (float("-inf"), None)

    def ask(self):
        self.generation += 1
        self.asked = [self.proposal(slot) for slot in range(self.population)]
        return self.asked

    def proposal(self, slot):
        stream, box = self.streams(self.generation, slot), self.box
        share = [stream.random() for _ in box.low]
        genome = [low + u * (high - low) for u, low, high in zip(share, box.low, box.high)]
        if self.best[1] is not None:
            genome = [0.7 * a + 0.3 * b for a, b in zip(self.best[1], genome)]
        whole = [round(x) if kind else x for x, kind in zip(genome, box.kinds)]
        return Proposal(tuple(map(float, whole)), Operator.SAMPLED, Birth(self.generation, slot))

    def tell(self, results):
        for proposal, result in zip(self.asked, results):
            if result.selectable:
                self.best = max(self.best, (result.continuous, proposal.genome))

def make(box, config, streams):
    return HillClimber(box, config.search.population, streams)

class Careless(HillClimber):
    def ask(self):
        return {FAULT}

def careless(box, config, streams):
    return Careless(box, config.search.population, streams)
'''
FAULTS = {
    "super().ask()[:-1]": "must propose 6 individuals in each generation, not 5",
    "[p.genome for p in super().ask()]": "not `tuple`",
    "[Proposal((1e9,) * len(self.box), Operator.RANDOM, Birth(0, i)) for i in range(6)]": "not a genome of the box",
    "super().ask()[::-1]": "calls it born at",
    "1 / 0": "failed in `ask`: ZeroDivisionError",
}


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[str], None]]:
    """Put a small package, as an installer would leave it, where Python looks."""

    def write(fault: str = "super().ask()") -> None:
        (tmp_path / "hill_climber.py").write_text(HILL_CLIMBER.replace("{FAULT}", fault))
        metadata = tmp_path / "hill_climber-1.2.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: hill-climber\nVersion: 1.2\n")
        points = "climber = hill_climber:make\ncareless = hill_climber:careless\nbroken = hill_climber:nowhere\n"
        (metadata / "entry_points.txt").write_text(f"[cortexc.searchers]\n{points}ga = hill_climber:make\n")
        monkeypatch.syspath_prepend(str(tmp_path))

    yield write
    sys.modules.pop("hill_climber", None)


@pytest.fixture
def evaluate(space: ParamSpace, evaluators: Callable[..., Evaluate]) -> Evaluate:
    return evaluators(space, error_above=0.9)


def test_it_is_found_and_runs(install: Callable[..., None], space: ParamSpace, evaluate: Evaluate) -> None:
    """By its name, under a method of its own in every stream key; a name of ours stays ours."""
    with pytest.raises(UnknownMethodError):
        canonical("climber")
    install()
    assert set(plugins()) == {"climber", "careless", "broken"}
    assert set(known_searchers()) > {"climber", "ga"}
    assert distribution_of("climber") == ("hill-climber", "1.2")
    assert find_searcher("climber").summary == "of the package hill-climber"
    assert find_searcher("ga").number == Method.GA
    searcher = build_searcher("climber", Box.of(space), Config(search=CONFIG))
    found = run_campaign(Task(space, evaluate, CONFIG, "climber"), searcher)
    assert len(found.evaluations) == CONFIG.generations * CONFIG.population
    assert set(found.evaluations.keys[..., 1].flat) == {method_number("climber")}
    assert found.method == "climber"


def test_two_packages_draw_different_numbers(
    install: Callable[..., None], space: ParamSpace, evaluate: Evaluate
) -> None:
    """The same searcher under two names proposes other genomes, in scenes that draw from other streams."""
    install()
    searches = []
    for name in ("climber", "careless"):
        searcher = build_searcher(name, Box.of(space), Config(search=CONFIG))
        searches.append(run_campaign(Task(space, evaluate, CONFIG, name), searcher).evaluations)
    first, second = searches
    assert not np.isin(first.genomes[:, 0], second.genomes[:, 0]).any()
    assert not np.isin(first.keys[..., 1], second.keys[..., 1]).any()


@pytest.mark.parametrize("number", [method_number("climber"), None])
def test_its_journal_is_gone_on_with(
    install: Callable[..., None],
    space: ParamSpace,
    evaluate: Evaluate,
    manifests: Callable[..., Manifest],
    tmp_path: Path,
    number: int | None,
) -> None:
    """Read back, replayed and resumed, as any other; and read where the package is gone. A journal from before
    names made numbers (None) has all searchers of other packages under one, and goes on with it.
    """
    install()
    manifest = replace(manifests(space, CONFIG, "climber"), number=number)
    journal = Journal.create(tmp_path / "journal.sqlite", manifest)
    method = Method.CUSTOM if number is None else number
    assert manifest.method_number == method

    def search(generations: int, past: list) -> None:
        config = SearchConfig(**{**vars(CONFIG), "generations": generations})
        searcher = build_searcher("climber", Box.of(space), Config(search=config), manifest.method_number)
        task = Task(space, evaluate, config, "climber")
        run_campaign(task, searcher, journal.write, past=Past(past, number=method))

    search(2, [])
    search(4, read_journal(journal.path).past())
    journal.close()
    (tmp_path / "hill_climber-1.2.dist-info" / "entry_points.txt").write_text("")
    record = read_journal(tmp_path / "journal.sqlite")
    assert len(record.generations) == 4
    assert record.manifest == manifest
    assert np.all(record.evaluations.keys[..., 1] == method)


def test_only_a_number_that_the_name_makes_is_kept(space: ParamSpace, manifests: Callable[..., Manifest]) -> None:
    """So that the journals of our own methods stay what they were."""
    kept = manifests(space, CONFIG, "ga")
    assert "number" not in kept.stored()
    assert kept.method_number == Method.GA
    assert replace(kept, method="climber", number=method_number("climber")).stored()["number"] == method_number(
        "climber"
    )


@pytest.mark.parametrize("fault", FAULTS)
def test_a_breach_of_the_protocol_is_said(install: Callable[..., None], space: ParamSpace, fault: str) -> None:
    """Before anything is simulated, with the name of the searcher."""
    install(fault)
    searcher = build_searcher("careless", Box.of(space), Config(search=CONFIG))
    with pytest.raises(PluginError, match="careless") as caught:
        searcher.ask()
    assert FAULTS[fault] in str(caught.value)


def test_a_package_that_cannot_be_loaded(install: Callable[..., None], space: ParamSpace) -> None:
    """Named with what went wrong in it."""
    install()
    with pytest.raises(PluginError, match="`broken` cannot be loaded: AttributeError"):
        build_searcher("broken", Box.of(space), Config(search=CONFIG))
