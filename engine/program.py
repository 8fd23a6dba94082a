"""`Program`: a compiled scenario as data. The one type between the language and the engine.

A program contains arrays, tables and names, and is independent of the language: it can be saved, hashed, sent to
another machine, sampled, simulated by either host and searched. As bytes it is one `.npz` file; its digest covers all
data that determine a result.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, replace
from hashlib import blake2b
from itertools import chain, count
from pathlib import Path
from typing import Any, cast
from zipfile import BadZipFile

import numpy as np

from engine.control import Control, control_from
from engine.errors import CortexError
from engine.frozen import frozen
from engine.judged import NOTHING_JUDGED, Judged, judged_from
from engine.maps import MapSpec, map_content, map_from
from engine.tables import ROAD_INDEX, CodeTables, Floats, Ints, RoadTables, is_left_out, kept_road
from engine.vocabulary import RuleKind


@frozen
class ParamSpace:
    """The genes, in the order of the file. A genome is one row of values in the file's own units."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    """Unit in the file, else that of the gene's places (SI); "" for pure numbers and option indices."""
    kinds: Ints
    """(d,) `GeneKind`."""
    low: Floats
    """(d,) inclusive, file units. Bounds of the search box."""
    high: Floats
    distribution: Ints
    """(d,) `Distribution` of the gene in a plain run."""
    shape: Floats
    """(d, 2) Mean and standard deviation (file units) of a truncated normal; else unused."""
    scale: Floats
    """(d,): SI value = file value * scale."""
    options: tuple[tuple[str, ...], ...]
    """Printable options of an INDEX gene; () otherwise."""
    weights: tuple[tuple[float, ...], ...]
    """Probabilities of a DISCRETE gene's options; () otherwise."""
    system: tuple[str, ...] = ()
    """Names of the params that belong to the system under test; a fixed param is not a gene."""
    bare: tuple[str, ...] = ()
    """Names of the genes without a unit in the file."""

    def __len__(self) -> int:
        return len(self.names)


@frozen
class Requirement:
    """One `require`, or a built-in or variant rejection, for reports."""

    name: str
    """Name given by the author (`as "..."`), or its source text; shown with every count."""
    line: int
    """Line in the source; 0 for a built-in."""
    probability: float = 1.0
    unit: str = ""
    """SI unit of its margin."""
    display_unit: str = ""
    """Unit in which its amounts are displayed: that of its source; "" for the SI unit."""
    display_scale: float = 1.0
    """SI amount = displayed amount * scale."""


@frozen
class Rule:
    """A condition that is evaluated in every sample, or that code triggers: see `vocabulary.RuleKind`."""

    name: str
    line: int
    kind: RuleKind = RuleKind.TERMINATE


@frozen
class Record:
    """A value that the file records: over time (`series`), or at one end (`initial`, `final`)."""

    name: str
    when: str
    rule: int
    """The rule of kind WATCH."""
    unit: str
    line: int
    during: int = -1
    """The rule of kind WATCH that is true in the samples that count; -1: all do."""


@frozen
class ChoiceLabel:
    """A finite choice as a variant made it. `start`, `end`: its place in the source, for a concrete copy."""

    name: str
    option: str
    option_source: str
    start: int
    end: int


@frozen
class DrawSite:
    """A nuisance draw in the source: its place, and the scene values that contain its result (see ir.DrawSite)."""

    kind: str
    unit: str
    """Its word; for a sampled lane, the name of the choice."""
    start: int
    end: int
    values: tuple[int, ...]
    """Indices of scene values."""


@frozen
class VariantLabel:
    """One combination of all finite choices, for reports and for concrete copies."""

    probability: float
    choices: tuple[ChoiceLabel, ...]
    sites: tuple[DrawSite, ...]
    sight: int = -1
    """Index of the scene value with the weather's range of sight [m], or -1."""


@frozen
class Settings:
    """Settings of the simulation in the file; None if the file does not set one and the config decides."""

    time_step: float | None = None
    max_time: float | None = None
    """Time limit of `terminate after` [s]."""
    max_attempts: int | None = None
    stream: str | None = None
    """Stream key fixed by a concrete file, so that a found case replays exactly."""
    fair: bool = False
    """True if scenes must have a fair start: braking at once avoids every collision (`engine.fairness`)."""

    pedals_stay: bool = False
    """True if a pedal keeps its value, as in Scenic, instead of one step only."""

    def deciding(self) -> dict[str, float | int | str | bool | None]:
        """Return the settings that enter the digest of a program."""
        return {name: value for name, value in asdict(self).items() if name not in ("fair", "pedals_stay") or value}


@frozen
class ImportedText:
    """A file that the main file imports, with its text at compilation."""

    name: str
    start: int
    """Offset of its first character in the space of all texts."""
    first_line: int
    """Number of its first line, counted through all texts."""
    text: str


@frozen
class Program:
    """A compiled scenario. See `engine.tables` for the arrays; nothing in here refers back to text."""

    name: str
    description: str
    digest: str
    """Hash of all data that determine a result; names and text are excluded."""
    source_text: str
    """The file as written, for reports and concrete copies; runs do not use it."""
    space: ParamSpace
    actors: tuple[str, ...]
    """Actor names; actor 0 is the ego."""
    requirements: tuple[Requirement, ...]
    """Requirements in testing order: the file's own, then `variant` rejections, then the built-in ones (`outlines
    inside the road`, `no overlap at the start`, and `fair start` if the file requests it).
    """
    rules: tuple[Rule, ...]
    variants: tuple[VariantLabel, ...]
    settings: Settings
    code: CodeTables
    road: RoadTables
    road_spec: MapSpec
    step_lines: Ints
    """(rows of step_code,): source line of each instruction, for messages about running behaviours."""
    routes: Ints
    """(variants, actors) Path that each actor is known to follow, or -1; for drawing and for conflict metrics."""
    records: tuple[Record, ...] = ()
    monitors: tuple[str, ...] = ()
    """Names of the coroutines without an actor."""
    imported: tuple[ImportedText, ...] = ()
    judged: Judged = NOTHING_JUDGED
    controls: tuple[Control, ...] = ()
    """Actors that are driven externally."""

    @property
    def first_built_in(self) -> int:
        """Return the number of the first built-in requirement; that of fair starts is the last, if it exists."""
        return len(self.requirements) - (3 if self.settings.fair else 2)

    def place(self, line: int) -> str:
        """Return a line for messages: its number, and the name of its file if that is not the main file."""
        for file in reversed(self.imported):
            if line >= file.first_line:
                return f"{file.name}:{line - file.first_line + 1}"
        return str(line)


# -- as bytes ----------------------------------------------------------------------------------------------------------

FORMAT = "cortexc program 2"


class ArchiveError(CortexError):
    """The file is not a program that this version can read."""


def program_digest(
    space: ParamSpace,
    code: CodeTables,
    road: RoadTables,
    settings: Settings,
    judged: Judged = NOTHING_JUDGED,
    controls: Sequence[Control] = (),
) -> str:
    """Return 32 hexadecimal digits over all numbers of a program; names, text and drawings do not count."""
    digest = blake2b(FORMAT.encode(), digest_size=16)
    for prefix, group in (("space", _arrays_of(space)), ("code", code._asdict()), ("road", road._asdict())):
        for name, array in group.items():
            if prefix == "road" and (name in ROAD_INDEX or is_left_out(road, name)):
                continue
            digest.update(f"{prefix}.{name}{array.dtype.str}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(json.dumps([settings.deciding(), space.weights]).encode())
    if len(judged):
        digest.update(json.dumps(judged.deciding()).encode())
        digest.update(b"".join(array.tobytes() for array in judged.arrays().values()))
    if controls:
        digest.update(json.dumps([asdict(control) for control in controls]).encode())
    return digest.hexdigest()


def save_program(program: Program, path: Path) -> None:
    """Write the program as one `.npz` file: its arrays, and all other data as JSON in `header`."""
    road = program.road
    arrays = {
        **{f"space.{name}": array for name, array in _arrays_of(program.space).items()},
        **{f"code.{name}": array for name, array in program.code._asdict().items()},
        **{f"road.{name}": array for name, array in road._asdict().items() if not is_left_out(road, name)},
        **program.judged.arrays(),
        **_arrays_of(program),
    }
    header = json.dumps({"format": FORMAT, **_plain(program)})
    with path.open("wb") as file:
        np.savez_compressed(file, **cast("Any", {"header": np.array(header), **arrays}))


def load_program(path: Path) -> Program:
    """Return the program that `save_program` wrote.

    Raises:
        ArchiveError: not a program, of another format version, or damaged (its digest does not fit).
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            header = json.loads(str(archive["header"]))
            arrays = {name: archive[name] for name in archive.files if name != "header"}
    except (ValueError, KeyError, EOFError, OSError, BadZipFile) as error:
        raise ArchiveError(f"{path} is not a saved program", "name a file that `save` wrote") from error
    if header.pop("format", None) != FORMAT:
        raise ArchiveError(f"{path} was written by another version", "use the version of cortexc that wrote it")
    program = _rebuild(header, arrays)
    deciding = program.space, program.code, program.road, program.settings, program.judged, program.controls
    if program_digest(*deciding) != program.digest:
        raise ArchiveError(f"{path} is damaged: its digest does not fit its contents", "restore it from a copy")
    return program


def _arrays_of(value: Any) -> dict[str, np.ndarray]:
    return {f.name: v for f in fields(value) if isinstance(v := getattr(value, f.name), np.ndarray)}


def _plain(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass that are neither arrays nor tables, as JSON can represent them."""
    plain: dict[str, Any] = {}
    for f in fields(value):
        item = getattr(value, f.name)
        if isinstance(item, ParamSpace):
            plain[f.name] = _plain(item)
        elif isinstance(item, Judged):
            plain[f.name] = item.content()
        elif isinstance(item, MapSpec):
            plain[f.name] = map_content(item)
        elif not isinstance(item, np.ndarray | CodeTables | RoadTables):
            plain[f.name] = _jsonable(item)
    return plain


def _jsonable(item: Any) -> Any:
    if hasattr(item, "__dataclass_fields__"):
        return asdict(item)
    if isinstance(item, tuple):
        return [_jsonable(i) for i in cast("tuple[Any, ...]", item)]
    return item


def _rebuild(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Program:
    def group(prefix: str) -> dict[str, Any]:
        return {name.removeprefix(prefix): a for name, a in arrays.items() if name.startswith(prefix)}

    space = {name: _tuples(value) for name, value in header["space"].items()}
    own = {name: array for name, array in arrays.items() if "." not in name}
    values: dict[str, Any] = {
        **header,
        **own,
        "space": ParamSpace(**space, **group("space.")),
        "code": CodeTables(**group("code.")),
        "road": kept_road(group("road.")),
        "road_spec": map_from(header["road_spec"]),
        "settings": Settings(**header["settings"]),
        "actors": tuple(header["actors"]),
        "requirements": tuple(Requirement(**r) for r in header["requirements"]),
        "rules": tuple(Rule(**_with(r, kind=RuleKind(r["kind"]))) for r in header["rules"]),
        "records": tuple(Record(**r) for r in header["records"]),
        "monitors": tuple(header["monitors"]),
        "imported": tuple(ImportedText(**file) for file in header["imported"]),
        "variants": tuple(_variant(v) for v in header["variants"]),
        "judged": judged_from(header.get("judged"), arrays),
        "controls": tuple(control_from(each) for each in header.get("controls", ())),
    }
    return Program(**values)


def _variant(value: Mapping[str, Any]) -> VariantLabel:
    sites = (DrawSite(**_with(site, values=tuple(site["values"]))) for site in value["sites"])
    choices = tuple(ChoiceLabel(**c) for c in value["choices"])
    return VariantLabel(value["probability"], choices, tuple(sites), value.get("sight", -1))


def _with(values: Mapping[str, Any], /, **others: Any) -> dict[str, Any]:
    """Return the values with some of them replaced by the objects that they encode."""
    return {**values, **others}


def _tuples(value: Any) -> Any:
    """Return JSON's lists as tuples, at every depth."""
    return tuple(_tuples(v) for v in cast("list[Any]", value)) if isinstance(value, list) else value


# -- names of finite choices -------------------------------------------------------------------------------------------


def drawn_lanes(label: VariantLabel) -> list[DrawSite]:
    """Return the lanes that a scene of the variant samples."""
    return [site for site in label.sites if site.kind == "lane"]


def choice_names(label: VariantLabel) -> list[str]:
    """Return the unique names of a variant's choices, followed by those of its sampled lanes."""
    return numbered([*(choice.name for choice in label.choices), *(site.unit or "lane" for site in drawn_lanes(label))])


def numbered(names: Sequence[str]) -> list[str]:
    """Return unique names: the second `a` is `a 2`."""
    taken = dict[str, None]()
    for name in names:
        further = (f"{name} {number}" for number in count(2))
        taken[next(each for each in chain([name], further) if each not in taken)] = None
    return list(taken)


# -- built-in requirements for some actors -----------------------------------------------------------------------------


def checking(program: Program, road: Sequence[int], overlap: Sequence[int]) -> Program:
    """Return the program with built-in requirements for these actors only: on the road, and not overlapping."""
    code = program.code._replace(
        road_check=_only(program.code.road_check, road), overlap_check=_only(program.code.overlap_check, overlap)
    )
    return replace(program, code=code)


def _only(flags: Ints, chosen: Sequence[int]) -> Ints:
    limited = np.zeros_like(flags)
    limited[list(chosen)] = flags[list(chosen)]
    return limited
