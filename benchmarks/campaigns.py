"""What the benchmarks of searches share: a plan over the examples, carried out by the code of the study."""

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from cortex_dsl import load
from engine.paper import FILES
from engine.study.database import StudyStore, is_study, read_study
from engine.study.execution import perform_all
from engine.study.plan import Address, Plan, Subject, check, with_own_seeds
from engine.study.run_records import Finished, RunRecord

EXAMPLES = Path(__file__).parent.parent / "examples"


def parser(description: str | None, runs: int, *, keeps: bool = True) -> argparse.ArgumentParser:
    """The options that they all have."""
    made = argparse.ArgumentParser(description=(description or "").splitlines()[0])
    made.add_argument("files", nargs="*", type=Path, help="scenarios (the six examples)")
    made.add_argument("--runs", type=int, default=runs, help=f"runs of each method on each scenario ({runs})")
    made.add_argument("--generations", type=int, default=30)
    made.add_argument("--population", type=int, default=100)
    made.add_argument("--objective", default="risk", help="what searches look for (the paper's risk)")
    made.add_argument("--fixed", default="", help="params held at a value: EGO_BRAKE=0.5,SAFETY_DIST=10 (none)")
    made.add_argument("--preset", choices=("cortex", "cortex-literal"), default="cortex")
    made.add_argument("--seed", type=int, default=0)
    made.add_argument("--jobs", type=int, default=1, help="processes; results never depend on it (1)")
    if keeps:
        made.add_argument("--keep", type=Path, metavar="FOLDER", help="keep each run, and go on from those kept there")
    made.add_argument("--json", action="store_true", help="print one JSON document instead of a table")
    return made


def plan_of(options: argparse.Namespace, methods: Sequence[str]) -> Plan:
    """The plan that the options ask for, checked."""
    files = options.files or [EXAMPLES / f"{name}.scn" for name in FILES]
    subjects = with_own_seeds([_subject(file, options) for file in files])
    plan = Plan(subjects, tuple(methods), options.runs, objective=(options.objective,))
    check(plan)
    return plan


def _subject(file: Path, options: argparse.Namespace) -> Subject:
    fixed = dict(pair.split("=", 1) for pair in options.fixed.split(",") if pair)
    scenario = load(file, **fixed)
    budget = {name: getattr(options, name) for name in ("generations", "population", "seed")}
    config = scenario.config
    config = replace(config, search=replace(config.search, **budget), ga=replace(config.ga, preset=options.preset))
    return Subject(file.stem, str(file), scenario.program, config)


def carried_out(plan: Plan, jobs: int, keep: Path | None = None) -> tuple[list[RunRecord], float]:
    """Every run in the order of the plan, and how long those took that were made now [s].

    With a folder each run is kept there, as a study, and whatever it holds of the same plan is not made again.
    """
    start = time.perf_counter()
    found, store = _kept(plan, keep) if keep else ({}, None)
    before, total = len(found), plan.runs * len(plan.subjects) * len(plan.methods)

    def on_run(finished: Finished) -> None:
        if store:
            store.write(finished)
        found[finished.record.address] = finished.record
        if len(found) * 10 // total > (len(found) - 1) * 10 // total:
            print(f"{len(found)} of {total} runs, {time.perf_counter() - start:.0f} s", file=sys.stderr, flush=True)

    try:
        perform_all(plan, on_run, jobs, frozenset(found))
    finally:
        if store:
            store.close()
            print(f"{len(found) - before} runs more in {keep}", file=sys.stderr)
    return [found[address] for address in plan.addresses()], time.perf_counter() - start


def _kept(plan: Plan, folder: Path) -> tuple[dict[Address, RunRecord], StudyStore]:
    """What a folder holds of a plan, and where to keep the rest."""
    if not is_study(folder):
        folder.mkdir(parents=True, exist_ok=True)
        return {}, StudyStore.create(folder, plan, {})
    there = read_study(folder)
    if _asked(there.plan) != _asked(plan):
        sys.exit(f"{folder} holds runs of another plan: {_asked(there.plan)}")
    return {record.address: record for record in there.records}, StudyStore.reopen(folder)


def _asked(plan: Plan) -> tuple[object, ...]:
    subjects = [(subject.name, subject.program.digest, subject.config.search) for subject in plan.subjects]
    return subjects, plan.methods, plan.runs, plan.objective
