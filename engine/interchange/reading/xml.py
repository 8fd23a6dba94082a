"""The one reader of XML files: what a stranger's file can do here is be refused.

No document type, entity or external reference is accepted, so nothing is ever expanded, opened or fetched; size,
depth and number of elements are bounded before memory is spent. Sources: OWASP, "XML External Entity Prevention Cheat
Sheet"; Python, "The ElementTree XML API: XML vulnerabilities".
"""

import stat
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import NoReturn
from xml.parsers import expat

from engine.interchange.errors import InterchangeError, quoted
from engine.interchange.reading.node import Node

CHUNK = 1 << 22
"""Bytes. An attribute that fills many chunks is looked at again with each, so that small ones would cost minutes."""
MEGABYTE = 1_000_000
KINDS: Mapping[str, str] = MappingProxyType(
    {
        "OpenSCENARIO": "an OpenSCENARIO file",
        "OpenDRIVE": "an OpenDRIVE road",
        "commonRoad": "a CommonRoad scenario",
        "CommonRoadSolution": "a CommonRoad solution",
        "osm": "an OpenStreetMap file",
        "html": "a web page",
        "net": "a SUMO network",
    }
)
ENDINGS: Mapping[str, str] = MappingProxyType({"OpenSCENARIO": ".xosc", "OpenDRIVE": ".xodr"})
BINARY: Mapping[bytes, str] = MappingProxyType(
    {b"PK\x03\x04": "a zip archive", b"\x1f\x8b": "a gzip archive", b"\x89MCAP": "an MCAP file", b"PAR1": "Parquet"}
)


@dataclass(frozen=True)
class Limits:
    """What a file may cost; a recording of twenty actors over ten minutes stays below each."""

    megabytes: float = 80.0
    elements: int = 1_000_000
    depth: int = 64
    attributes: int = 50
    """Of one element."""
    all_attributes: int = 2_500_000
    tag_megabytes: float = 12.0
    """Of one tag or comment, which the parser holds as a whole; a property of half a million numbers is shorter."""


LIMITS = Limits()


def read_xml(path: Path, root: str, limits: Limits = LIMITS) -> Node:
    """The root element of a file, with all that is in it.

    Raises:
        InterchangeError: no such file, not XML, another root than `root`, larger than `limits`, or with a DTD.
    """
    reader = _Reader(path.name, limits)
    try:
        with _regular(path).open("rb") as file:
            while chunk := file.read(CHUNK):
                reader.feed(chunk)
    except OSError as error:
        raise _unreadable(path, error) from None
    return _of_kind(reader.close(), root)


def _regular(path: Path) -> Path:
    """The path itself, if reading it comes to an end."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise InterchangeError("this is a folder", "name a file in it", path.name)
    if not stat.S_ISREG(mode):
        raise InterchangeError("this is not a regular file", "name a file on disk", path.name)
    return path


def _unreadable(path: Path, error: OSError) -> InterchangeError:
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return InterchangeError("there is no such file", f"looked for {quoted(str(path))}", path.name)
    return InterchangeError(f"it cannot be read: {error.strerror}", "mend that, or copy the file", path.name)


def _of_kind(node: Node, root: str) -> Node:
    if node.tag == root:
        return node
    kind = KINDS.get(node.tag, f"an XML file of another kind, <{quoted(node.tag)[1:-1]}>")
    raise node.error(f"this is {kind}", f"name the {ENDINGS.get(root, root)}, whose root is <{root}>")


class _Reader:
    """Expat's events become nodes, and its errors ours."""

    def __init__(self, file: str, limits: Limits) -> None:
        self.file = file
        self.limits = limits
        self.size = 0
        self.elements = 0
        self.attributes = 0
        self.open: list[Node] = []
        self.root: Node | None = None
        self.parser = expat.ParserCreate()
        self.parser.SetParamEntityParsing(expat.XML_PARAM_ENTITY_PARSING_NEVER)
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.StartDoctypeDeclHandler = self._refuse
        self.parser.EntityDeclHandler = self._refuse
        self.parser.ExternalEntityRefHandler = self._refuse

    def feed(self, chunk: bytes) -> None:
        if not self.size:
            self._look_at(chunk)
        self.size += len(chunk)
        if self.size > self.limits.megabytes * MEGABYTE:
            most = f"{self.limits.megabytes:g} MB"
            raise self._error(f"the file is larger than {most}", "leave out actors, or take fewer samples a second")
        self._parse(chunk, False)
        if self.size - self.parser.CurrentByteIndex > self.limits.tag_megabytes * MEGABYTE:
            most = f"{self.limits.tag_megabytes:g} MB"
            raise self._error(f"one tag or comment is longer than {most}", "leave out actors or samples")

    def close(self) -> Node:
        if not self.size:
            raise InterchangeError("the file is empty", "write it again, or name another", self.file)
        self._parse(b"", True)
        if self.root is None:
            raise self._error("there is no element in it", "name an XML file")
        return self.root

    def _look_at(self, head: bytes) -> None:
        """Say what a binary file is, where that is known."""
        for magic, kind in BINARY.items():
            if head.startswith(magic):
                raise InterchangeError(f"this is {kind}, not XML", "unpack it, or name the XML file", self.file)

    def _parse(self, chunk: bytes, last: bool) -> None:
        try:
            self.parser.Parse(chunk, last)
        except expat.ExpatError as error:
            place = f"{self.file}, line {error.lineno}, column {error.offset + 1}"
            message = f"this is not well-formed XML: {expat.ErrorString(error.code)}"
            raise InterchangeError(message, "mend the file there, or name an XML file", place) from None
        except (ValueError, LookupError) as error:
            message = f"its encoding cannot be read: {quoted(str(error))[1:-1]}"
            raise self._error(message, "save it as UTF-8") from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.elements += 1
        if self.elements > self.limits.elements:
            raise self._error(f"it has more than {self.limits.elements} elements", "leave out actors or samples")
        self._count_attributes(tag, len(attributes))
        if len(self.open) >= self.limits.depth:
            raise self._error(f"elements stand more than {self.limits.depth} deep", "no format here needs that")
        node = Node(tag, attributes, self.file, self.parser.CurrentLineNumber)
        if self.open:
            self.open[-1].children.append(node)
        else:
            self.root = node
        self.open.append(node)

    def _count_attributes(self, tag: str, count: int) -> None:
        self.attributes += count
        most, in_all = self.limits.attributes, self.limits.all_attributes
        if count > most:
            raise self._error(f"<{quoted(tag)[1:-1]}> has {count:,} attributes", f"write at most {most} in an element")
        if self.attributes > in_all:
            raise self._error(f"it has more than {in_all:,} attributes", "leave out actors or samples")

    def _end(self, _: str) -> None:
        self.open.pop()

    def _refuse(self, *_: object) -> NoReturn:
        raise self._error("it declares a document type or entities, which are never read", "take <!DOCTYPE …> out")

    def _error(self, message: str, cure: str) -> InterchangeError:
        return InterchangeError(message, cure, f"{self.file}, line {self.parser.CurrentLineNumber}")
