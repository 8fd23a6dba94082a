"""A `Program` as bytes: saved, loaded, and named by a digest of everything that decides a result."""

import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from hashlib import blake2b
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from engine.errors import CortexError
from engine.program import (
    ChoiceLabel,
    DrawSite,
    ImportedText,
    ParamSpace,
    Program,
    Record,
    Requirement,
    RoadSpec,
    Rule,
    Settings,
    VariantLabel,
)
from engine.tables import CodeTables, RoadTables
from engine.vocabulary import RuleKind

FORMAT = "cortexc program 1"


class ArchiveError(CortexError):
    """The file is not a program that this version can read."""


def program_digest(space: ParamSpace, code: CodeTables, road: RoadTables, settings: Settings) -> str:
    """32 hexadecimal digits over all numbers of a program; names, text and drawings do not count."""
    digest = blake2b(FORMAT.encode(), digest_size=16)
    for prefix, group in (("space", _arrays_of(space)), ("code", code._asdict()), ("road", road._asdict())):
        for name, array in group.items():
            digest.update(f"{prefix}.{name}{array.dtype.str}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(json.dumps([asdict(settings), space.weights]).encode())
    return digest.hexdigest()


def save(program: Program, path: Path) -> None:
    """Write the program as one `.npz` file: its arrays, and everything else as JSON in `header`."""
    arrays = {
        **{f"space.{name}": array for name, array in _arrays_of(program.space).items()},
        **{f"code.{name}": array for name, array in program.code._asdict().items()},
        **{f"road.{name}": array for name, array in program.road._asdict().items()},
        **_arrays_of(program),
    }
    header = json.dumps({"format": FORMAT, **_plain(program)})
    with path.open("wb") as file:
        np.savez_compressed(file, header=np.array(header), allow_pickle=False, **arrays)


def load(path: Path) -> Program:
    """Read what `save` wrote.

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
    if program_digest(program.space, program.code, program.road, program.settings) != program.digest:
        raise ArchiveError(f"{path} is damaged: its digest does not fit its contents", "restore it from a copy")
    return program


def _arrays_of(value: Any) -> dict[str, np.ndarray]:
    return {f.name: v for f in fields(value) if isinstance(v := getattr(value, f.name), np.ndarray)}


def _plain(value: Any) -> dict[str, Any]:
    """The fields of a dataclass that are neither arrays nor tables, as JSON can hold them."""
    plain: dict[str, Any] = {}
    for f in fields(value):
        item = getattr(value, f.name)
        if isinstance(item, ParamSpace):
            plain[f.name] = _plain(item)
        elif not isinstance(item, np.ndarray | CodeTables | RoadTables):
            plain[f.name] = _jsonable(item)
    return plain


def _jsonable(item: Any) -> Any:
    if hasattr(item, "__dataclass_fields__"):
        return asdict(item)
    if isinstance(item, tuple):
        return [_jsonable(i) for i in item]
    return item


def _rebuild(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> Program:
    def group(prefix: str) -> dict[str, Any]:
        return {name.removeprefix(prefix): a for name, a in arrays.items() if name.startswith(prefix)}

    space = {name: _tuples(value) for name, value in header["space"].items()}
    own = {name: array for name, array in arrays.items() if "." not in name}
    return Program(
        **{
            **header,
            **own,
            "space": ParamSpace(**space, **group("space.")),
            "code": CodeTables(**group("code.")),
            "road": RoadTables(**group("road.")),
            "road_spec": RoadSpec(**header["road_spec"]),
            "settings": Settings(**header["settings"]),
            "actors": tuple(header["actors"]),
            "requirements": tuple(Requirement(**r) for r in header["requirements"]),
            "rules": tuple(Rule(**{**r, "kind": RuleKind(r["kind"])}) for r in header["rules"]),
            "records": tuple(Record(**r) for r in header["records"]),
            "monitors": tuple(header["monitors"]),
            "imported": tuple(ImportedText(**file) for file in header["imported"]),
            "variants": tuple(_variant(v) for v in header["variants"]),
        }
    )


def _variant(value: Mapping[str, Any]) -> VariantLabel:
    sites = (DrawSite(**{**site, "values": tuple(site["values"])}) for site in value["sites"])
    return VariantLabel(value["probability"], tuple(ChoiceLabel(**c) for c in value["choices"]), tuple(sites))


def _tuples(value: Any) -> Any:
    """JSON's lists back to tuples, at every depth."""
    return tuple(_tuples(v) for v in value) if isinstance(value, list) else value
