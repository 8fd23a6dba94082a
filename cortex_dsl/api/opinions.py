"""A second opinion on the worst cases of a run, by a better model of the car; stored next to the journal.

`cx.verify("runs/left_turn-ga-001", cases=10)` gives one answer for each of the ten worst.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cortex_dsl.api import arguments
from cortex_dsl.api.derived_files import VERIFICATION
from cortex_dsl.api.runs import OpenedRun, open_run
from engine.assessment import concatenate
from engine.atomic import write_one
from engine.checksums import stamp, with_checksum
from engine.display import counted, facts_table
from engine.errors import ArgumentError
from engine.risk import PROFILES
from engine.search.ranking import WORST, Case
from engine.search.store import store_errors
from engine.strict_json import json_text
from engine.verification import Answer, Verified
from engine.verification import verify as verify_scenes

MODELS = ("dynamic",)


@dataclass(frozen=True)
class Verification:
    """Cases of a run, worst first, and the answer on each."""

    cases: tuple[Case, ...]
    answers: tuple[Verified, ...]

    def __len__(self) -> int:
        return len(self.cases)

    def __repr__(self) -> str:
        """One line, for notebooks."""
        counts = ", ".join(f"{count} {name}" for name, count in self._counts())
        return f"Verification({counted(len(self), 'case')}: {counts})"

    def _repr_html_(self) -> str:
        return facts_table([("cases", str(len(self))), *((name, str(count)) for name, count in self._counts())])

    def _counts(self) -> list[tuple[str, int]]:
        counts = Counter(found.answer for found in self.answers)
        return [(answer.name.lower().replace("_", " "), counts[answer]) for answer in Answer if counts[answer]]


def verify(
    run: OpenedRun | str | Path, cases: int = WORST, *, model: str = MODELS[0], jobs: int | None = None
) -> Verification:
    """Run the worst cases of a run again, with finer steps and with cars whose tyres slip (`engine.verification`).

    Raises:
        StoreError: there is no readable run, or a case of it has no scene.
    """
    arguments.kind("run", run, (OpenedRun, str, Path), "name the folder of a run, or open it")
    if model not in MODELS:
        raise ArgumentError(f"there is no model `{model}`", f"name one of {', '.join(MODELS)}")
    opened = run if isinstance(run, OpenedRun) else open_run(run)
    chosen = opened.first_cases(arguments.whole("cases", cases, 1))
    if not chosen:
        return Verification((), ())
    config = opened.scenario.config
    threads = config.search.jobs if jobs is None else arguments.whole("jobs", jobs, 1)
    scenes = concatenate([opened.scene(case) for case in chosen])
    profile = PROFILES[opened.record.manifest.profile]
    found = verify_scenes(opened.scenario.program, scenes, config.simulation, profile, threads, config.contact)
    return Verification(chosen, tuple(answer for answer in found if answer is not None))


def keep(run: OpenedRun, content: Mapping[str, Any]) -> Path:
    """Write answers, in the form of a document, next to the journal; return the file, which is whole or absent.

    Raises:
        StoreError: it cannot be written.
    """
    path = run.folder / VERIFICATION
    with store_errors(path):
        text = json_text({**stamp(run.record.link), **content}, indent=2)
        write_one(path, with_checksum(f"{text}\n"))
    return path
