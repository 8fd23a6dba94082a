"""A case for export: run again, recorded, with its provenance."""

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from shlex import join

from cortex_dsl import ir
from cortex_dsl.api.concrete import gene_text
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.lowering.code_tables import group_variants
from cortex_dsl.lowering.given_out import HERE, given_out, light_times
from cortex_dsl.version import VERSION
from engine.interchange.recording import Provenance, RecordedCase, SignalTimes, Surroundings, recorded_run
from engine.outcomes import Outcomes
from engine.risk import HIGHEST_RISK, Risk
from engine.scenes import Scenes
from engine.search.ranking import Case
from engine.search.store import without_folders
from engine.streams import format_key
from engine.vocabulary import Verdict

# -- data of one scene that programs do not contain --------------------------------------------------------------------


def signal_times(scenario: Scenario, scenes: Scenes, row: int = 0) -> SignalTimes | None:
    """The plan of the traffic lights in scene `row`; None without lights, and where there is no scene."""
    return light_times(scenario.compiled.scenario, scenes, row, scenario.config.simulation)


def surroundings_of(scenario: Scenario, scenes: Scenes, row: int = 0) -> Surroundings | None:
    """The weather in scene `row`, which is worked out as the times of the lights are; None where the file says none."""
    whole, number = scenario.compiled.scenario, int(scenes.variant[row])
    given = () if number < 0 else group_variants(whole).variants[number].environment
    if not given:
        return None
    values = given_out(whole, scenes, row, scenario.config.simulation, _with_environment)
    return Surroundings(**{name: value for (name, _), value in zip(given, values, strict=True)})


def _with_environment(variant: ir.Variant) -> ir.Variant:
    if not variant.environment:
        return variant
    given = tuple(value for _, value in variant.environment)
    return replace(variant, draw_sites=(*variant.draw_sites, ir.DrawSite(HERE, "number", "", given)))


# -- the case ----------------------------------------------------------------------------------------------------------

LONGEST_NAME = 80
"""Characters of a scenario's name in the names of files, which file systems limit to 255."""
NO_DATE = "1970-01-01T00:00:00"
PARTS = ("C", "MD", "D_MS", "TTC_MS")


@dataclass(frozen=True)
class ExportCase(RecordedCase):
    """One simulation, row 0 of its scenes, and the result of running it again."""

    scenario: Scenario
    scenes: Scenes
    run: OpenedRun | None = None
    """The search that found it; None for the scene of a file."""
    rank: int | None = None
    """Rank in that search, 1 is the worst; None without a search."""

    @property
    def road_provenance(self) -> Provenance:
        """The text on the road, which all cases of a scenario share."""
        facts = {
            name: text for name, text in self.recording.provenance.facts.items() if name in ("scenario", "version")
        }
        title = f"the road of {self.scenario.program.name}"
        return replace(self.recording.provenance, title=title, facts=facts, genome={})


def case_of_run(run: OpenedRun, case: Case) -> ExportCase:
    """One case of a run, from its genome and stream key."""
    manifest = run.record.manifest
    again = {
        "search": join(["cortexc", *map(without_folders, manifest.command_line)]) if manifest.command_line else "",
        "command": join(["cortexc", "replay", without_folders(str(run.folder)), "--case", str(case.rank)]),
    }
    origin = _Origin(run.scenario, run.scene(case), manifest.profile, manifest.file, again)
    name = f"{road_name(run.scenario)}-case{case.rank:02d}"
    return replace(_export_case(origin, name), run=run, rank=case.rank)


def case_of_scene(scenario: Scenario, scenes: Scenes, file: Path, seed: int | None, command: str) -> ExportCase:
    """The scene of a file, drawn by a seed (None: the stream that a concrete file pins); `command` shows it again."""
    origin = _Origin(scenario, scenes, "paper", str(file), {"command": command})
    name = road_name(scenario)
    return _export_case(origin, name if seed is None else f"{name}-seed{seed}")


def case_of_search(scenario: Scenario, case: Case, name: str = "") -> ExportCase:
    """A case of a search that keeps no run, as the session's do not."""
    origin = _Origin(scenario, scenario.scene(case), "paper", scenario.compiled.source.name, {})
    made = _export_case(origin, name or f"{road_name(scenario)}-case{case.rank:02d}")
    return replace(made, rank=case.rank)


def road_name(scenario: Scenario) -> str:
    """The stem of the files that all cases of a scenario share."""
    return re.sub(r"[^A-Za-z0-9_.-]+", "-", scenario.program.name).strip("-.")[:LONGEST_NAME] or "scenario"


@dataclass(frozen=True)
class _Origin:
    """Where a case comes from: which scene of which file, and the commands that show it again."""

    scenario: Scenario
    scenes: Scenes
    profile: str
    file: str
    again: Mapping[str, str]


def _export_case(origin: _Origin, name: str) -> ExportCase:
    scenario, scenes = origin.scenario, origin.scenes
    run = scenario.watch(scenes)
    recording = recorded_run(
        scenario.program,
        scenes,
        run,
        step=scenario.config.simulation.time_step,
        name=name,
        surroundings=surroundings_of(scenario, scenes),
    )
    signals, provenance = signal_times(scenario, scenes), _provenance(origin, run.outcomes)
    recording = replace(recording, signals=signals, provenance=provenance)
    return ExportCase(recording, run.outcomes, origin.profile, scenario, scenes)


def _provenance(origin: _Origin, outcomes: Outcomes) -> Provenance:
    program = origin.scenario.program
    risk = origin.scenario.assess(outcomes, origin.profile)
    key = origin.scenes.keys[0].tolist()
    facts = {
        "scenario": without_folders(origin.file),
        "seed": str(key[0]),
        "stream": format_key(key),
        "digest": program.digest,
        "risk": risk_text(risk, outcomes, origin.profile),
        **{name: text for name, text in origin.again.items() if text},
        "version": f"cortexc {VERSION}",
    }
    title = " ".join(program.description.split("\n\n")[0].split()) or program.name
    return Provenance(title=title, date=_date(), facts=facts, genome=_genome(origin))


def risk_text(risk: Risk, outcomes: Outcomes, profile: str) -> str:
    """`18 of 22 (C 10, MD 4, D_MS 4, TTC_MS 0; profile paper)`, or that there is none."""
    if outcomes.verdict[0] != Verdict.VALID:
        return f"none, the run was {Verdict(int(outcomes.verdict[0])).name.lower()}"
    parts = ", ".join(f"{name} {points}" for name, points in zip(PARTS, risk.parts[0].tolist(), strict=True))
    return f"{int(risk.score[0])} of {HIGHEST_RISK} ({parts}; profile {profile})"


def _genome(origin: _Origin) -> dict[str, str]:
    """Value of each param, those that were held fixed among them."""
    program = origin.scenario.program
    values: Sequence[float] = origin.scenes.genomes[0].tolist()
    drawn = {name: gene_text(program, gene, values[gene]) for gene, name in enumerate(program.space.names)}
    return {**origin.scenario.overrides, **drawn}


def _date() -> str:
    """Return the date for files of formats that need one: a constant, so that the same case gives the same file.

    A case is defined by its seed; neither journals nor scenarios store a time, and a copy loses the time of change of a
    file. SOURCE_DATE_EPOCH can set the date, as for reproducible builds
    (https://reproducible-builds.org/specs/source-date-epoch/).
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH", "")
    try:
        return datetime.fromtimestamp(int(epoch), UTC).strftime("%Y-%m-%dT%H:%M:%S")
    except (ValueError, OverflowError, OSError):
        return NO_DATE
