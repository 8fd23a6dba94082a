"""Check whether a run is the output of its search, and whether its simulations are reproducible.

`cx.prove("runs/left_turn-ga-001")` reads the whole journal, which checks its chain (`engine.search.chain`), and runs a
sample of its simulations again.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cortex_dsl.api import arguments
from cortex_dsl.api.derived_files import Difference, refusal
from cortex_dsl.api.restoring import compared, compared_study
from cortex_dsl.api.runs import OpenedRun, open_run
from engine.config import Config
from engine.display import facts_table
from engine.driving.decisions import name_of
from engine.search.evaluations import Evaluations
from engine.search.evaluator import Repeated, repeat, sampled
from engine.search.journal_reader import damaged
from engine.search.manifest import changed_versions
from engine.search.past import recorded_driver
from engine.search.store import JOURNAL
from engine.study.database import read_evaluations, read_study
from engine.tables import Bools
from engine.vocabulary import Blame

SAMPLE = 200
"""Simulations that are run again."""


@dataclass(frozen=True)
class Proof:
    """Facts about a readable journal."""

    proved: bool
    """Whether its chain holds; a journal from before there were chains has none."""
    generations: int
    simulations: int
    """Number of distinct simulations."""
    again: int
    """How many of them were run again."""
    differ: tuple[str, ...]
    """Those that come to something else, such as `generation 3, place 7, rollout 0`."""
    files: int
    """Number of files next to the journal that were compared with it."""
    changed: tuple[str, ...]
    """Those of them that do not follow from it."""
    reasons: tuple[str, ...]
    """Why they may, without the journal being damaged: other versions, or a driver that does not repeat itself."""
    remarks: tuple[str, ...]
    """Remarks on omitted parts."""

    def __repr__(self) -> str:
        """One line, for notebooks."""
        return f"Proof({'proved' if self.proved else 'unproved'}: {self.text})"

    @property
    def text(self) -> str:
        """Return the result of the repeated simulations."""
        if not self.again:
            return "nothing was run again"
        same = self.again - len(self.differ)
        return f"{same:,} of {self.again:,} simulations that were run again are the same, bit for bit"

    @property
    def first(self) -> str:
        """The first that differs, and how many more; empty for none."""
        *more, first = self.differ[::-1] or ("",)
        return f"{first}, and {len(more):,} more," if more else first

    def _repr_html_(self) -> str:
        chain = "holds" if self.proved else "none: an earlier version wrote the journal"
        return facts_table([("chain", chain), ("run again", str(self.again)), ("differ", str(len(self.differ)))])


def prove(run: OpenedRun | str | Path, sample: int = SAMPLE, *, jobs: int | None = None) -> Proof:
    """Check the chain of a run's journal, and run `sample` of its simulations again.

    Raises:
        StoreError: there is no readable run, its journal is damaged, or one of its simulations has another result
            without a known reason.
    """
    arguments.kind("run", run, (OpenedRun, str, Path), "name the folder of a run, or open it")
    opened = run if isinstance(run, OpenedRun) else open_run(run)
    count = arguments.whole("sample", sample, 0)
    evaluations, manifest, scenario = opened.record.evaluations, opened.record.manifest, opened.scenario
    config = scenario.config
    if jobs is not None:
        config = replace(config, search=replace(config.search, jobs=arguments.whole("jobs", jobs, 1)))
    among, remarks = _driven_again(opened)
    rows = sampled(evaluations, count, among)
    done = repeat(scenario.program, config, manifest.profile, manifest.objective, evaluations, rows)
    if not done.with_objectives:
        remarks = (*remarks, "an objective that is a Python function is not computed again")
    _check_blame(opened)
    files, left_out = compared(opened)
    differences = _differences(files)
    differ = tuple(_name(evaluations, *row) for row in done.rows[~done.same].tolist())
    proof = Proof(
        proved=opened.record.proved,
        generations=len(opened.record.generations),
        simulations=int(evaluations.simulated.sum()) * evaluations.rollouts.verdict.shape[1],
        again=len(done.rows),
        differ=differ,
        files=len(files),
        changed=tuple(differences),
        reasons=_reasons(opened),
        remarks=(*remarks, *left_out),
    )
    if proof.differ and not proof.reasons and _is_of_driver(opened, config, done):
        driver = opened.record.manifest.driver
        reason = f"`{driver.name if driver else ''}` may decide otherwise than when it drove in the run"
        return replace(proof, reasons=(reason,))
    if proof.differ and not proof.reasons:
        raise damaged(
            opened.folder / JOURNAL, f"the simulation of {proof.first} gives another result when it is repeated"
        )
    if proof.changed and not proof.reasons:
        raise refusal(opened.folder, differences)
    return proof


def _check_blame(run: OpenedRun) -> None:
    """Let the reference driver drive again after the collisions of a run, if the journal has its answers.

    Raises:
        StoreError: it answers otherwise.
    """
    stored = run.record.blame
    if stored is None or _reasons(run):
        return
    again = run.blame_again
    if ((again != stored) & (again != Blame.NONE)).any():
        raise damaged(run.folder / JOURNAL, "the reference driver answers otherwise when it drives again")


@dataclass(frozen=True)
class StudyProof:
    """Facts about a readable study."""

    proved: bool
    """Whether its seal holds; a study from before there were seals has none."""
    runs: int
    evaluations: int
    files: int
    """Number of files next to the study that were compared with it."""
    remarks: tuple[str, ...]
    """Remarks on omitted parts."""


def prove_study(folder: Path) -> StudyProof:
    """Check the seal of a study, the digest of each run's evaluations, and the files next to it.

    Raises:
        StoreError: there is no readable study, it is damaged, or a file next to it does not follow from it.
    """
    study = read_study(folder)
    evaluations = sum(len(read_evaluations(study, record.address)) for record in study.records)
    files, left_out = compared_study(study)
    if differences := _differences(files):
        raise refusal(folder, differences)
    return StudyProof(study.proved, len(study.records), evaluations, len(files), tuple(left_out))


def _differences(files: Mapping[str, Difference | None]) -> dict[str, Difference]:
    return {name: difference for name, difference in files.items() if difference is not None}


def _is_of_driver(run: OpenedRun, config: Config, done: Repeated) -> bool:
    """Return whether the driver explains all differences: recorded decisions, where stored, give equal simulations."""
    driver, manifest, evaluations = config.driver, run.record.manifest, run.record.evaluations
    if driver is None or not driver.can_drive_new_scenes:
        return False
    config = replace(config, driver=recorded_driver(driver, run.record.actions))
    rows = [
        row
        for row in done.rows[~done.same].tolist()
        if name_of(evaluations.keys[*row], evaluations.genomes[row[0]]) in run.record.actions
    ]
    again = np.array(rows, dtype=np.int64).reshape(-1, 2)
    repeated = repeat(run.scenario.program, config, manifest.profile, manifest.objective, evaluations, again)
    return bool(repeated.same.all())


def _name(evaluations: Evaluations, individual: int, rollout: int) -> str:
    generation, place = evaluations.places[individual].tolist()
    return f"generation {generation}, place {place}, rollout {rollout}"


def _driven_again(run: OpenedRun) -> tuple[Bools, tuple[str, ...]]:
    """Return (n, k) simulations that can be run again, and remarks on the others.

    Without the controller of the run, only those with recorded decisions can be run again.
    """
    evaluations, driver = run.record.evaluations, run.scenario.config.driver
    keys, genomes = evaluations.keys, evaluations.genomes
    if driver is None or driver.can_drive_new_scenes:
        return np.ones(keys.shape[:2], dtype=np.bool_), ()
    has_decisions = [
        [name_of(key, genome) in run.record.actions for key in rollouts]
        for rollouts, genome in zip(keys, genomes, strict=True)
    ]
    among = np.array(has_decisions, dtype=np.bool_).reshape(keys.shape[:2])
    remark = f"only simulations whose decisions are kept are run again; `{driver.name}` is needed for all others"
    return among, (remark,)


def _reasons(run: OpenedRun) -> tuple[str, ...]:
    """Return reasons why simulations may have another result although the journal is intact."""
    manifest = run.record.manifest
    changed = changed_versions(manifest)
    reasons = [f"the run was made with {', '.join(changed)}"] if changed else []
    if manifest.driver is not None and not manifest.driver.reproducible:
        reasons.append(f"`{manifest.driver.name}` does not repeat itself")
    return tuple(reasons)
