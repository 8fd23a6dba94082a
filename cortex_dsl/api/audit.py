"""The page for an auditor from a search: its numbers, and the tables from which they can be computed again.

`audit_of_run` reads the journal. It drives worst cases and, for `domain` lines, the independent draws once more, which
gives the same runs. Other sources are `cortex_dsl.api.audit_documents`. Prints nothing.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from hashlib import sha256
from itertools import product
from pathlib import Path
from shlex import join

import numpy as np

from cortex_dsl import ir
from cortex_dsl.api.derived_files import VERIFICATION
from cortex_dsl.api.domain_cells import DomainPrograms
from cortex_dsl.api.exposure import Exposure
from cortex_dsl.api.opinions import keep, verify
from cortex_dsl.api.run_folder import KeptFiles
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.plain_text import as_argument
from cortex_dsl.report.findings.audit_report import (
    ONE_DRIVER,
    VERDICTS,
    AuditReport,
    Cell,
    Event,
    Finding,
    NotRun,
    Provenance,
    Topic,
    dynamic_finding,
    effort_finding,
    exposure_finding,
    failures_finding,
    missing,
    platform_text,
    probability_finding,
    step_finding,
    unseen_finding,
    verdicts_finding,
)
from cortex_dsl.report.findings.readable import counted, first_line, significant
from cortex_dsl.report.findings.search_report import headline, invalid_counts, method_name, unfinished
from cortex_dsl.report.findings.verification_report import ANSWERS, verification_content
from cortex_dsl.source import Source
from engine.driving.blocks import redriven
from engine.errors import ArgumentError, ControllerError
from engine.gates.coverage import MOST_CELLS, OUTSIDE
from engine.gates.coverage import counted as counted_cells
from engine.search.insight.analysis import judged_again
from engine.search.insight.independent import (
    COLLISION,
    draws_independently,
    independent_draws,
    rows_of_draws,
    runs_of_draws,
)
from engine.search.insight.kinds import codes_of_draws, collisions_of, failures
from engine.search.manifest import changed_versions
from engine.search.probability.unseen import NO_KIND, labels
from engine.search.ranking import WORST
from engine.search.result_files import csv_table
from engine.search.store import StoreError, without_folders
from engine.streams import format_key
from engine.strict_json import plain
from engine.tables import Bools, Floats, Ints
from engine.verification import Answer
from engine.vocabulary import Blame, EndReason, Sense, Verdict

DRAWS, COLLISIONS, CASES = "audit-draws.csv", "audit-collisions.csv", "audit-cases.csv"
"""Tables beside the page: independent draws, collisions with their verdicts, worst cases."""
OF_DRAWS = (Topic.FAILURES, Topic.EXPOSURE, Topic.PROBABILITY, Topic.UNSEEN)
"""Numbers that come from independent draws."""


@dataclass(frozen=True)
class _Draws:
    """The independent draws of a search."""

    rows: Ints
    """(n,) individuals"""
    valid: Bools
    lost: Bools
    collided: Bools
    broken: Mapping[str, Bools]
    """Broken `expect`s by name."""
    failed: Bools
    mechanism: Ints
    """(n,) number of the kind of collision, `NO_KIND` without one."""


@dataclass(frozen=True)
class _AuditedCase:
    """One of the worst cases."""

    rank: int
    individual: int
    adapted: bool | None
    """True if adapted speed avoids the collision; None without one of which the ego is at fault."""
    dynamic: str
    """Answer of the dynamic model; "" without one."""


def audit_of_run(run: OpenedRun, exposure: Exposure | None = None, command: str = "") -> AuditReport:
    """Return the page of a search; `command` writes it again.

    Raises:
        ArgumentError: the exposure does not fit the domains of the file.
        StoreError: a case has no scene.
    """
    return _RunAudit(run, exposure, command).report()


class _RunAudit:
    def __init__(self, run: OpenedRun, exposure: Exposure | None, command: str) -> None:
        self.run, self.exposure, self.command = run, exposure, command
        self.record, self.scenario = run.record, run.scenario
        self.manifest, self.evaluations = run.record.manifest, run.record.evaluations
        self.program = run.scenario.program
        self.expects = [o.name for o in self.program.judged.objectives if o.sense is Sense.EXPECT]
        self.failure = "a broken `expect`" if self.expects else "a contact of the ego"
        self.tables: dict[str, bytes] = {}
        self.not_run: list[NotRun] = []
        self.no_dynamic = "no case of the search can be driven again"

    def report(self) -> AuditReport:
        """Return the page.

        Raises:
            ArgumentError, StoreError: as `audit_of_run`.
        """
        manifest = self.manifest
        came = failures(self.evaluations, self.run.blame)
        found = tuple(self._findings())
        for why, count in invalid_counts(self.record).items():
            self.not_run.append(NotRun("simulations that do not count", why, count))
        left = manifest.config.search.generations - len(self.record.generations)
        if left > 0:
            self.not_run.append(NotRun("generations", f"the search {unfinished(self.record)}", left))
        config = manifest.config.simulation
        parameters = [f"{p.name} {_range(p.low, p.high, p.unit, p.options)}" for p in manifest.parameters]
        size = manifest.config.search.population
        steps = f"{counted(len(self.record.generations), 'generation')} of {size:,} by {method_name(manifest.method)}, "
        return AuditReport(
            kind="search",
            id=f"{manifest.name}/{manifest.program_digest[:12]}/{manifest.method}/{manifest.seed}.{manifest.run}",
            objective=first_line(self.program.description) or manifest.name,
            scenario=f"{without_folders(manifest.file)}, text {manifest.file_digest[:12]}",
            inputs="; ".join(parameters) or "no params",
            steps=f"{steps}runs of at most {significant(config.max_time)} s in steps of "
            f"{significant(config.time_step)} s",
            platform=platform_text(manifest.platform, manifest.versions),
            expected="; ".join(self.expects) or "no contact of the ego",
            result=headline(self.record, came),
            findings=found,
            not_run=tuple(self.not_run),
            command=self.command,
            cautions=tuple(self._cautions()),
            tables=self.tables,
            evidence={name: sha256(content).hexdigest() for name, content in self.tables.items()}
            | ({} if self.exposure is None else {self.exposure.name: self.exposure.digest}),
            journal=self.record.link,
        )

    def _cautions(self) -> list[str]:
        said: list[str] = []
        if words := unfinished(self.record):
            said.append(f"The search {words}: the numbers are those of what its journal holds so far.")
        if changed := changed_versions(self.manifest):
            said.append(f"The search was made with {', '.join(changed)}; another version may give other numbers.")
        if not self.record.proved:
            said.append("The journal has no digests that prove it unchanged.")
        driver = self.manifest.driver
        if driver is not None and not driver.reproducible:
            said.append(f"The driver `{driver.name}` is not deterministic: it drove a scene otherwise the second time.")
        return said

    # -- sources

    @cached_property
    def folder(self) -> str:
        return as_argument(Path(without_folders(str(self.run.folder))))

    def _source(self, *tables: str, command: str = "") -> Provenance:
        """Return the source of a number of this search."""
        manifest = self.manifest
        words = [without_folders(word) for word in manifest.command_line]
        if not words:
            made = f"a search from Python (seed {manifest.seed}, run {manifest.run})"
        else:
            made = join(["cortexc", *words])
        return Provenance(
            command=command or f"{made}, then {self.command}",
            file=without_folders(manifest.file),
            digests={without_folders(manifest.file): manifest.program_digest},
            seed=manifest.seed,
            version=manifest.versions.get("cortexc", ""),
            tables=tables,
        )

    # -- numbers

    def _findings(self) -> list[Finding]:
        drawn = self.draws
        collisions = self._verdicts()
        found = [
            *(self._of_draws(drawn) if drawn is not None else self._without_draws()),
            collisions,
            missing(Topic.DEVIATION, "a search has no tolerances; `cortexc suite` finds it for each cell of a suite"),
            missing(Topic.COMPARISON, ONE_DRIVER),
            self._dynamic(),
            step_finding(self.scenario.config.simulation.time_step, self.manifest.versions.get("cortexc", "")),
            self._effort(),
        ]
        for each in found:
            if each.reason:
                self.not_run.append(NotRun(each.topic.value, each.reason))
        return found

    def _without_draws(self) -> list[Finding]:
        method = self.manifest.method
        if draws_independently(method):
            reason = "none of its independent draws is valid"
        else:
            reason = f"the scenes of {method_name(method)} are no independent draws"
        cure = f"`cortexc {as_argument(Path(without_folders(self.manifest.file)))} --random` draws them"
        if self.exposure is not None:
            raise ArgumentError(f"--exposure weights independent draws: {reason}", cure)
        return [missing(topic, f"{reason}; {cure}") for topic in OF_DRAWS]

    @cached_property
    def draws(self) -> _Draws | None:
        """Return the independent draws; None without a valid one."""
        evaluations, method = self.evaluations, self.manifest.method
        runs = runs_of_draws(evaluations, method)
        valid = runs.verdict == Verdict.VALID
        if not valid.any():
            return None
        rows = rows_of_draws(evaluations, method)
        columns = dict(zip(self.manifest.objectives, runs.broken.T, strict=True))
        broken = {name: columns[name] == 1.0 for name in self.expects}
        contact = runs.collided | (runs.end_reason == EndReason.BUILDING)
        failed = np.any(list(broken.values()), axis=0) if broken else contact
        mechanism = np.full(len(rows), NO_KIND, dtype=np.int64)
        mechanism[valid] = labels(codes_of_draws(runs, runs.collided))
        lost = runs.verdict == Verdict.CONTROLLER
        return _Draws(rows, valid, lost, runs.collided, broken, failed & valid, mechanism)

    def _of_draws(self, drawn: _Draws) -> list[Finding]:
        """Return the numbers of independent draws, and write their table."""
        known = independent_draws(self.evaluations, self.manifest.method, self.manifest.objectives)
        assert known is not None
        domains = self._domains(drawn)
        self.tables[DRAWS] = csv_table(self._draws_table(drawn, domains))
        source = self._source(DRAWS)
        lost, valid = int(drawn.lost.sum()), drawn.valid
        remarks: list[str] = []
        if domains.domains:
            cells = [
                Cell(f"{domain.name} {cell.text}", *self._counts(drawn, domains.places[:, number] == place))
                for number, domain in domains.domains.items()
                for place, cell in enumerate(domain.cells)
            ]
            outside = int(valid.sum()) - int((valid & (domains.every >= 0).any(axis=1)).sum())
            remarks += [f"{counted(outside, 'draw')} in no cell of any domain"] if outside else []
            remarks += domains.remarks
        else:
            cells = [Cell("all", *self._counts(drawn, valid))]
            remarks += domains.remarks or ["the file has no domain lines: one cell, the whole file"]
        events = [Event(COLLISION, int((drawn.collided & valid).sum()), known.valid, lost)]
        events += [Event(name, int((rows & valid).sum()), known.valid, lost) for name, rows in drawn.broken.items()]
        return [
            failures_finding(cells, self.failure, source, remarks),
            self._exposed(drawn, domains, source),
            probability_finding(events, source),
            unseen_finding(known.unseen, known.valid, source),
        ]

    def _counts(self, drawn: _Draws, inside: Bools) -> tuple[int, int, int]:
        """Return the numbers of valid draws and of failures among some draws, and of all lost draws."""
        return int((drawn.valid & inside).sum()), int((drawn.failed & inside).sum()), int(drawn.lost.sum())

    def _draws_table(self, drawn: _Draws, domains: "_Domains") -> dict[str, list[object]]:
        def texts(number: int, domain: ir.Domain) -> list[object]:
            return [
                domain.cells[place].text if place >= 0 else "outside" if place == OUTSIDE else ""
                for place in domains.places[:, number].tolist()
            ]

        return {
            "individual": drawn.rows.tolist(),
            "valid": drawn.valid.astype(int).tolist(),
            "lost": drawn.lost.astype(int).tolist(),
            "failed": drawn.failed.astype(int).tolist(),
            "collision": (drawn.collided & drawn.valid).astype(int).tolist(),
            **{f"broken {name}": (rows & drawn.valid).astype(int).tolist() for name, rows in drawn.broken.items()},
            "mechanism": ["" if label == NO_KIND else label for label in drawn.mechanism.tolist()],
            **{
                f"value of {domain.name}": (domains.values[:, number] / domain.scale).tolist()
                for number, domain in domains.domains.items()
            },
            **{f"cell of {domain.name}": texts(number, domain) for number, domain in domains.domains.items()},
        }

    # -- domains

    def _domains(self, drawn: _Draws) -> "_Domains":
        """Return the domains with their values in the draws, which are driven once more."""
        declared = self.scenario.compiled.scenario.domains
        nothing = np.zeros((len(drawn.rows), len(declared)))
        if not declared:
            return _Domains({}, nothing, nothing.astype(np.int64), [])
        manifest, evaluations = self.manifest, self.evaluations
        source = Source(manifest.file, manifest.file_text)
        files = KeptFiles(manifest.origin, self.run.folder)
        programs = DomainPrograms(self.scenario, source, manifest.seed, self.scenario.config.search.jobs, files)
        scenes = programs.scenes(evaluations.genomes[drawn.rows], evaluations.keys[drawn.rows, 0])
        driver, remarks = self.scenario.config.driver, list[str]()
        chosen = dict(enumerate(declared))
        if driver is not None and not driver.can_drive_new_scenes:
            chosen = {number: declared[number] for number in programs.starts}
            left = [each.name for number, each in enumerate(declared) if number not in chosen]
            remarks += [f"without the driver (--ego) no values of {', '.join(left)}"] if left else []
            values = programs.start_values(scenes)
        else:
            try:
                driven = scenes if driver is None else redriven(self.program, scenes, self.scenario.config)
                values = programs.values_of_runs(driven)
            except ControllerError as error:
                return _Domains({}, nothing, nothing.astype(np.int64), [f"no values of domains: {error.message}"])
        values[~drawn.valid] = math.nan
        return _Domains(chosen, values, programs.places(values), remarks)

    def _exposed(self, drawn: _Draws, domains: "_Domains", source: Provenance) -> Finding:
        """Return the failure rate under the exposure.

        Raises:
            ArgumentError: it does not fit.
        """
        exposure, names = self.exposure, {each.name: number for number, each in domains.domains.items()}
        if exposure is None:
            how = "--exposure FILE gives a weight to each cell of the `domain` lines"
            return missing(Topic.EXPOSURE, f"no exposure is given; {how}")
        declared = {each.name for each in self.scenario.compiled.scenario.domains}
        if not declared:
            what = f"`{exposure.path}` weights cells, but {without_folders(self.manifest.file)} has no `domain` lines"
            raise ArgumentError(what, "write `domain` lines into the file, and search again")
        for name in exposure.columns:
            if name in declared - names.keys():
                what = f"`{exposure.path}` weights cells of `{name}`: {'; '.join(domains.remarks)}"
                raise ArgumentError(what, "give the driver: --ego python:package.module:function")
            if name not in names:
                there = ", ".join(f"`{each.name}`" for each in self.scenario.compiled.scenario.domains)
                raise ArgumentError(f"`{exposure.path}`, line 1: there is no domain `{name}`", f"there are {there}")
        numbers = [names[name] for name in exposure.columns]
        sizes = [len(domains.domains[number].cells) for number in numbers]
        if math.prod(sizes) > MOST_CELLS:
            what = f"`{exposure.path}`: the product of its domains has {math.prod(sizes):,} cells"
            raise ArgumentError(what, "weight fewer domains")
        every = list(product(*map(range, sizes)))
        places, valid, lost = domains.places[:, numbers], drawn.valid, int(drawn.lost.sum())
        inside = counted_cells(places[valid], drawn.failed[valid], np.zeros(int(valid.sum())))
        counts = [
            (inside[cell].runs, inside[cell].failures, lost) if cell in inside else (0, 0, lost) for cell in every
        ]
        texts = [
            tuple(domains.domains[number].cells[place].text for number, place in zip(numbers, cell, strict=True))
            for cell in every
        ]
        weights = exposure.weights_of(texts, lambda cell: counts[cell][0] > 0)
        cells = [Cell(", ".join(text), *count) for text, count in zip(texts, counts, strict=True)]
        return exposure_finding(cells, weights, exposure.name, source)

    # -- verdicts, models, effort

    def _verdicts(self) -> Finding:
        """Return the verdicts of the reference drivers on all collisions, and adapted speed on the worst."""
        evaluations, blame = self.evaluations, self.run.blame
        hit = collisions_of(evaluations)
        rows, rollouts = np.nonzero(hit)
        said = [Blame(code).name.lower() if code != Blame.NONE else "unknown" for code in blame[hit].tolist()]
        self.tables[COLLISIONS] = csv_table(
            {"individual": rows.tolist(), "rollout": rollouts.tolist(), "verdict": said}
        )
        counts = {name: said.count(name) for name in VERDICTS}
        adapted = [case.adapted for case in self.cases if case.adapted is not None]
        names = self.scenario.config.search.references
        source = self._source(COLLISIONS, CASES)
        speed = (sum(adapted), len(adapted)) if adapted else None
        self.tables[CASES] = csv_table(
            {
                "case": [case.rank for case in self.cases],
                "individual": [case.individual for case in self.cases],
                "adapted_speed": ["" if case.adapted is None else int(case.adapted) for case in self.cases],
                "dynamic": [case.dynamic for case in self.cases],
            }
        )
        return verdicts_finding(counts, "collisions", source, names, speed)

    @cached_property
    def cases(self) -> list[_AuditedCase]:
        """Return the worst cases that can be driven again."""
        chosen = self.run.first_cases(WORST)
        judged = judged_again(self.program, self.evaluations, [case.row for case in chosen], self.scenario.config)
        others = [None if said is None else said.counterfactuals for said in judged]
        return [
            _AuditedCase(
                case.rank,
                case.row,
                None if other is None else other.adapted_speed,
                self._answers.get(format_key(case.key), ""),
            )
            for case, other in zip(chosen, others, strict=True)
        ]

    @cached_property
    def _answers(self) -> dict[str, str]:
        """Return the answers of the dynamic model by case key; they are made and kept if there are none."""
        if self.run.opinions or not self.run.first_cases(1):
            return self.run.opinions
        try:
            found = verify(self.run)
        except (StoreError, ControllerError) as error:
            self.no_dynamic = f"not run: {error.message}"
            return {}
        content = plain(verification_content(self.program, found.cases, found.answers))
        with suppress(StoreError):  # the page has the answers
            keep(self.run, content)
        return {case["key"]: case["answer"] for case in content["cases"]}

    def _dynamic(self) -> Finding:
        answers = [case.dynamic for case in self.cases if case.dynamic]
        if not answers:
            return missing(Topic.DYNAMIC, self.no_dynamic)
        names = [name for name, *_ in ANSWERS.values()]
        counts = {name: answers.count(name) for name in names}
        command = f"cortexc verify {self.folder} --model dynamic"
        source = self._source(CASES, VERIFICATION, command=f"{command}, then {self.command}")
        return dynamic_finding(counts, ANSWERS[Answer.SURVIVES][0], source)

    def _effort(self) -> Finding:
        config = self.scenario.config.search
        seconds = self.record.seconds if math.isfinite(self.record.seconds) else self.record.spent
        simulations = int(self.evaluations.simulated.sum()) * int(self.evaluations.keys.shape[1])
        return effort_finding(simulations, seconds * config.jobs, self._source("journal.sqlite"), exact=False)


@dataclass(frozen=True)
class _Domains:
    """Values of domains in draws."""

    domains: Mapping[int, ir.Domain]
    """Those with values, by their numbers."""
    values: Floats
    """(n, all domains) SI; NaN for none."""
    places: Ints
    """(n, all domains)"""
    remarks: list[str]

    @property
    def every(self) -> Ints:
        """Return (n, domains with values) the cells."""
        return self.places[:, list(self.domains)]


def _range(low: float, high: float, unit: str, options: Sequence[str]) -> str:
    if options:
        return f"of {counted(len(options), 'option')}"
    return f"{significant(low)} to {significant(high)} {unit}".rstrip()
