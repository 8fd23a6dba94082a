"""The Scenic file as a whole: its head, which finds the road, then the author's text; and the check of the file."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.interchange.cases import ExportCase
from cortex_dsl.interchange.scenic.scenic_names import STAND_INS, OutputBuffer
from cortex_dsl.interchange.scenic.write_expressions import Expressions
from cortex_dsl.interchange.scenic.write_statements import Statements, made
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.semantics.model.context import ValueRecorder
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes
from cortex_dsl.syntax.literals import write_docstring
from cortex_dsl.syntax.unparse import unparse
from engine.errors import InterchangeError
from engine.interchange.contract import Export, ExportOptions, Finding
from engine.maps import MapFile, map_name
from engine.road import build_network
from engine.vocabulary import State

MODEL = "scenic.domains.driving.model"
RUN_REMARK = "the start is exact; Scenic's own behaviors drive otherwise than ours, so a run of it is not the same run"
PEDALS = ("SetThrottleAction", "SetBrakeAction")
PEDAL_REMARK = "a pedal that is set holds until it is set again, not for one step"


@dataclass(frozen=True)
class _Texts:
    """The files of a concrete scenario, as a compiler asks for them (see `cortex_dsl.files.Files`)."""

    texts: Mapping[str, str]

    maps: Mapping[str, str]
    """Paths of the map files, by name."""

    def find(self, importer: str, paths: Sequence[str]) -> str | None:  # noqa: ARG002 - all lie side by side
        return next((self.maps.get(path, path) for path in paths if path in {*self.texts, *self.maps}), None)

    def read(self, name: str) -> Source:
        return Source(name, self.texts[name])

    def identity(self, name: str) -> str:
        return name

    def beside(self, importer: str, path: str) -> list[str]:  # noqa: ARG002 - for cures of spelling, which is right
        return []


def refuse_left_hand(case: ExportCase) -> None:
    """Raises InterchangeError for a road with left-hand traffic: Scenic 3.1 does not read `rule="LHT"` of OpenDRIVE."""
    if build_network(case.scenario.program.road_spec).left_hand:
        raise InterchangeError(
            "Scenic takes every road for one with right-hand traffic", "leave scenic out of --to for left-hand roads"
        )


def write_scenic(case: ExportCase, name: str, road_file: str) -> Export:
    """Return the file called `name`, and remarks on its omissions.

    Raises:
        InterchangeError: the imports of the scenario cannot be put into one file.
    """
    witness = ValueRecorder()
    compiled = _concrete(case, witness)
    sheet = OutputBuffer(compiled.source)
    to = Expressions(
        sheet=sheet,
        network=build_network(case.scenario.program.road_spec),
        known_values=lambda span: [observed.value for observed in witness.seen.get(span, ())],
        from_north=any(isinstance(each, nodes.Model) for each in compiled.module.statements),
        recording=case.recording,
        make=made,
    )
    statements = Statements(to, compiled.imports).all(_written(compiled.module))
    sheet.remark(RUN_REMARK)
    stay = case.scenario.program.settings.pedals_stay
    if not stay and any(isinstance(each, nodes.Name) and each.id in PEDALS for each in everything_in(compiled.module)):
        sheet.remark(PEDAL_REMARK)
    body = unparse(nodes.Module(statements, None, span=compiled.module.span))
    text = f"{_head(case, compiled.module, sheet, name, road_file)}\n{body}"
    return Export({name: text}, tuple(sheet.remarks))


def _written(module: nodes.Module) -> Iterator[nodes.Statement]:
    """Yield the statements except `pass`, which stands for `mutate` in a concrete copy."""
    return (each for each in module.statements if not isinstance(each, nodes.Pass))


def _concrete(case: ExportCase, witness: ValueRecorder) -> Compiled:
    """Compile the case as a scenario of its own; the witness records the values of its expressions."""
    texts = case.scenario.concrete_files(case.scenes, laid_out=False)
    main, spec = next(iter(texts)), case.scenario.program.road_spec
    maps = {map_name(spec): spec.path} if isinstance(spec, MapFile) else {}
    try:
        return compile_source(Source(main, texts[main]), files=_Texts(texts, maps), observe=witness)
    except CompileError as error:
        raise ValueError("a concrete scenario does not compile") from error


def _head(case: ExportCase, module: nodes.Module, sheet: OutputBuffer, name: str, road_file: str) -> str:
    """Return the text before the author's own statements."""
    parts = [_about(case, module, sheet, name), _model(case, road_file), _brought(sheet)]
    return "\n".join("".join(f"{line}\n" for line in part) for part in parts if part)


def _about(case: ExportCase, module: nodes.Module, sheet: OutputBuffer, name: str) -> list[str]:
    docstring = [] if module.docstring is None else [write_docstring(module.docstring), ""]
    facts = [f"# {what}: {text}" for what, text in case.recording.provenance.facts.items()]
    remarks = [f"# - {remark}" for remark in sheet.remarks]
    tail = ["#", "# Not as in the original:", *remarks]
    return [*docstring, *facts, "#", f"# To look at it: scenic --2d {name}", *tail]


def _model(case: ExportCase, road_file: str) -> list[str]:
    return [
        f"param timestep = {case.recording.step!r}",
        "param use2DMap = True",
        f"param map = localPath({road_file!r})",
        "# CARLA: `model scenic.simulators.carla.model` instead, which loads this map. MetaDrive:",
        "# `model scenic.simulators.metadrive.model`.",
        f"model {MODEL}",
    ]


def _brought(sheet: OutputBuffer) -> list[str]:
    """Return the definitions that the file needs and Scenic's library lacks.

    These are functions, road parts, classes and behaviours.
    """
    mathematics = [f"from math import {', '.join(sorted(sheet.mathematics))}"] if sheet.mathematics else []
    lookups = [f"{name} = {value}" for name, value in sheet.lookups.items()]
    classes = [line for name, base in sheet.classes.items() for line in (f"class {name}({base}):", "    pass")]
    return [*mathematics, *lookups, *classes, *_stand_ins(sheet)]


def _stand_ins(sheet: OutputBuffer) -> Iterator[str]:
    for name in sheet.stand_ins:
        stand_in = STAND_INS[name]
        yield ""
        yield f"behavior {name}({', '.join(filter(None, stand_in.parameters))}):"
        if stand_in.lacks:
            yield f"    # in its place: {stand_in.lacks}"
        yield from (f"    {line}" for line in stand_in.body)


# -- looked at again ---------------------------------------------------------------------------------------------------


def check_scenic(case: ExportCase, folder: Path, names: Sequence[str], _options: ExportOptions) -> Iterator[Finding]:
    """Check that the road file exists, and that every actor is at its start of the run."""
    for name in (each for each in names if each.endswith(".scenic")):
        text = (folder / name).read_text(encoding="utf-8")
        road = next((each for each in names if each.endswith(".xodr")), "")
        if f"localPath({road!r})" not in text or not (folder / road).is_file():
            yield Finding(name, "its road is not beside it", "export it again")
        for actor, state in zip(case.recording.actors, case.recording.states[0].tolist(), strict=True):
            place = re.escape(f"at ({state[State.X]!r}, {state[State.Y]!r})")
            if state[State.PRESENT] and not re.search(rf"new (?!Point|OrientedPoint)\w+ {place}", text):
                yield Finding(f"{name}, {actor.name}", "it does not stand where the run began", "export it again")
