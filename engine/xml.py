"""XML as every format here is read.

A hostile file is refused. No document type, entity or external reference is accepted, so nothing is ever expanded,
opened or fetched; size, depth and number of elements are bounded before memory is spent. Nodes remember their place.

Sources: OWASP, "XML External Entity Prevention Cheat Sheet"; Python, "The ElementTree XML API: XML vulnerabilities".
"""

import math
import re
import stat
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import NoReturn
from xml.parsers import expat

from engine.errors import InterchangeError, near_name, quoted

NUMBER = re.compile(r"\s*[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d{1,4})?\s*", re.ASCII)
"""xs:double of XML Schema without its infinities; Python alone would accept `1_000`, too."""
INFINITE = ("INF", "+INF", "inf", "Infinity")
LARGEST = 1e9
"""Largest length, time or angle of a real file: beyond it, arithmetic loses the millimetre."""


# -- elements of files of other tools, with error messages -------------------------------------------------------------


@dataclass(eq=False, slots=True)
class Node:
    """One element; its text is stored only on request, as few formats use it."""

    tag: str
    attributes: Mapping[str, str]
    file: str
    line: int
    children: list["Node"] = field(default_factory=list)
    content: str = ""
    read: set[str] | None = None
    """Names of the attributes that a reader has accessed; None if it never accessed the element itself."""

    @property
    def place(self) -> str:
        return f"{self.file}, line {self.line}"

    def error(self, message: str, cure: str) -> InterchangeError:
        """Return an error at this element."""
        return InterchangeError(message, cure, self.place)

    def every(self, *tags: str) -> list["Node"]:
        """Return the children of these names, in the order of the file."""
        return [node._asked() for node in self.children if node.tag in tags]

    def find(self, *path: str) -> "Node | None":
        """Return the first element down a path of names; None if there is none."""
        node: Node | None = self
        for tag in path:
            node = next((child._asked() for child in node.children if child.tag == tag), None) if node else None
        return node

    def has(self, *names: str) -> bool:
        """Return True if it has all of these attributes."""
        self._asked().read.update(names)  # type: ignore[union-attr]
        return all(name in self.attributes for name in names)

    def leave_out(self) -> None:
        """Record that the element is not read after all."""
        self.read = None

    def _asked(self) -> "Node":
        """Record that a reader has accessed this element."""
        if self.read is None:
            self.read = set()
        return self

    def need(self, *path: str) -> "Node":
        """Return the first element down a path of names.

        Raises:
            InterchangeError: there is none.
        """
        if (node := self.find(*path)) is not None:
            return node
        raise self.error(f"<{self.tag}> has no <{'/'.join(path)}>", f"write <{path[-1]}> into it")

    def only(self) -> "Node":
        """Return its only child element."""
        if len(self.children) == 1:
            return self.children[0]
        said = "is empty" if not self.children else f"holds {len(self.children)} elements"
        raise self.error(f"<{self.tag}> {said}", "it must hold exactly one")

    def walk(self) -> Iterator["Node"]:
        """Yield the element and everything within, in the order of the file."""
        stack: list[Node] = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children))

    def text(self, name: str, default: str | None = None) -> str:
        """Return an attribute.

        Raises:
            InterchangeError: it is missing and there is no default.
        """
        value = self.attributes.get(name, default)
        self._asked().read.add(name)  # type: ignore[union-attr]
        if value is None:
            near = near_name(name, self.attributes)
            cure = f"did you mean `{near}`?" if near else f'write {name}="…"'
            raise self.error(f"<{self.tag}> lacks the attribute `{name}`", cure)
        return value

    def number(self, name: str, default: float | None = None, low: float = -LARGEST, high: float = LARGEST) -> float:
        """Return an attribute as a number within bounds; with `high` infinite, INF is accepted, too.

        Raises:
            InterchangeError: missing without default, not a number, not finite, or out of bounds.
        """
        if default is not None and name not in self.attributes:
            return default
        text = self.text(name)
        if high == math.inf and text.strip() in INFINITE:
            return math.inf
        if not NUMBER.fullmatch(text):
            raise self.error(f"{name}={quoted(text)} is not a number", "write a finite decimal number")
        value = float(text)
        if not low <= value <= high:
            bounds = f"from {low:g} to {high:g}"
            raise self.error(f"{name}={quoted(text)} cannot be: it must be {bounds}", "correct the number")
        return value

    def content_number(self) -> float:
        """Return the number in its text.

        Raises:
            InterchangeError: it is not a finite number.
        """
        if not NUMBER.fullmatch(self.content) or not abs(value := float(self.content)) <= LARGEST:
            said = quoted(self.content.strip()) if self.content.strip() else "nothing"
            raise self.error(f"<{self.tag}> should hold a number, and holds {said}", "write a number into it")
        return value

    def integer(self, name: str) -> int:
        """Return an attribute as a whole number of at most nine digits."""
        text = self.text(name).strip()
        if not re.fullmatch(r"[+-]?\d{1,9}", text, re.ASCII):
            raise self.error(f"{name}={quoted(text)} is not a whole number", "write one such as -1")
        return int(text)


# -- the only reader ---------------------------------------------------------------------------------------------------

CHUNK = 1 << 22
"""Bytes per chunk. A long attribute is scanned again with each chunk, so small chunks would cost minutes."""
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
LESS: Mapping[str, str] = MappingProxyType({"OpenDRIVE": "cut the map down to the roads that are needed"})
"""Cures for too large a file of kinds that are not recordings."""
ENDINGS: Mapping[str, str] = MappingProxyType({"OpenSCENARIO": ".xosc", "OpenDRIVE": ".xodr"})
BINARY: Mapping[bytes, str] = MappingProxyType(
    {b"PK\x03\x04": "a zip archive", b"\x1f\x8b": "a gzip archive", b"\x89MCAP": "an MCAP file", b"PAR1": "Parquet"}
)


@dataclass(frozen=True)
class Limits:
    """Limits of a file; a recording of twenty actors over ten minutes stays below each."""

    megabytes: float = 80.0
    elements: int = 1_000_000
    depth: int = 64
    attributes: int = 50
    """Maximum number of attributes of one element."""
    all_attributes: int = 2_500_000
    tag_megabytes: float = 12.0
    """Maximum size of one tag or comment, which the parser holds as a whole; half a million numbers are smaller."""


LIMITS = Limits()


def read_xml(path: Path, root: str, limits: Limits = LIMITS, *, texts: bool = False) -> Node:
    """Return the root element of a file with all its content; `texts`: with the texts of its innermost elements.

    Raises:
        InterchangeError: no such file, not XML, another root than `root`, larger than `limits`, or with a DTD.
    """
    reader = _Reader(path.name, limits, texts, LESS.get(root, "leave out actors, or take fewer samples a second"))
    try:
        with _regular(path).open("rb") as file:
            while chunk := file.read(CHUNK):
                reader.feed(chunk)
    except OSError as error:
        raise _unreadable(path, error) from None
    return _of_kind(reader.close(), root)


def _regular(path: Path) -> Path:
    """Return the path itself if it is a regular file, or raise InterchangeError."""
    mode = path.stat().st_mode
    if stat.S_ISDIR(mode):
        raise InterchangeError("this is a folder", "name a file in it", path.name)
    if not stat.S_ISREG(mode):
        raise InterchangeError("this is not a regular file", "name a file on disk", path.name)
    return path


def _unreadable(path: Path, error: OSError) -> InterchangeError:
    if isinstance(error, FileNotFoundError | NotADirectoryError):
        return InterchangeError("there is no such file", f"looked for {quoted(str(path))}", path.name)
    return InterchangeError(f"it cannot be read: {error.strerror}", "solve that, or copy the file", path.name)


def _of_kind(node: Node, root: str) -> Node:
    if node.tag == root:
        return node
    kind = KINDS.get(node.tag, f"an XML file of another kind, <{quoted(node.tag)[1:-1]}>")
    raise node.error(f"this is {kind}", f"name the {ENDINGS.get(root, root)}, whose root is <{root}>")


class _Reader:
    """Expat's events become nodes, and its errors ours."""

    def __init__(self, file: str, limits: Limits, texts: bool, less: str) -> None:
        self.file = file
        self.less = less
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
        if texts:
            self.parser.CharacterDataHandler = self._text
        self.parser.StartDoctypeDeclHandler = self._refuse
        self.parser.EntityDeclHandler = self._refuse
        self.parser.ExternalEntityRefHandler = self._refuse

    def feed(self, chunk: bytes) -> None:
        if not self.size:
            self._look_at(chunk)
        self.size += len(chunk)
        if self.size > self.limits.megabytes * MEGABYTE:
            most = f"{self.limits.megabytes:g} MB"
            raise self._error(f"the file is larger than {most}", self.less)
        self._parse(chunk, False)
        if self.size - self.parser.CurrentByteIndex > self.limits.tag_megabytes * MEGABYTE:
            most = f"{self.limits.tag_megabytes:g} MB"
            raise self._error(f"one tag or comment is longer than {most}", "shorten it, or take it out")

    def close(self) -> Node:
        if not self.size:
            raise InterchangeError("the file is empty", "write it again, or name another", self.file)
        self._parse(b"", True)
        if self.root is None:
            raise self._error("there is no element in it", "name an XML file")
        return self.root

    def _look_at(self, head: bytes) -> None:
        """Raise InterchangeError for a known kind of binary file."""
        for magic, kind in BINARY.items():
            if head.startswith(magic):
                raise InterchangeError(f"this is {kind}, not XML", "unpack it, or name the XML file", self.file)

    def _parse(self, chunk: bytes, last: bool) -> None:
        try:
            self.parser.Parse(chunk, last)
        except expat.ExpatError as error:
            place = f"{self.file}, line {error.lineno}, column {error.offset + 1}"
            message = f"this is not well-formed XML: {expat.ErrorString(error.code)}"
            raise InterchangeError(message, "correct the file there, or name an XML file", place) from None
        except (ValueError, LookupError) as error:
            message = f"its encoding cannot be read: {quoted(str(error))[1:-1]}"
            raise self._error(message, "save it as UTF-8") from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self.elements += 1
        if self.elements > self.limits.elements:
            raise self._error(f"it has more than {self.limits.elements:,} elements", self.less)
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
            raise self._error(f"it has more than {in_all:,} attributes", self.less)

    def _end(self, _: str) -> None:
        self.open.pop()

    def _text(self, text: str) -> None:
        if self.open and not self.open[-1].children:
            self.open[-1].content += text

    def _refuse(self, *_: object) -> NoReturn:
        raise self._error("it declares a document type or entities, which are never read", "take <!DOCTYPE …> out")

    def _error(self, message: str, cure: str) -> InterchangeError:
        return InterchangeError(message, cure, f"{self.file}, line {self.parser.CurrentLineNumber}")
