"""HTML and SVG as trees of elements. Every text and every attribute is escaped, so that a name can do no harm."""

import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from typing import Any, TypeAlias

VOID = frozenset({"br", "hr", "img", "input", "link", "meta"})
"""Elements of HTML that have no end tag."""
UNPRINTABLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ud800-\udfff\ufffe\uffff]")
"""Characters that no document may hold."""


@dataclass(frozen=True)
class Verbatim:
    """Our own style, script or data, which must stand as it is. Made by `style`, `script` and `data_block` alone."""

    text: str


@dataclass(frozen=True)
class Element:
    """One element with what it holds."""

    tag: str
    attributes: Mapping[str, Any]
    children: tuple["Node", ...]

    def __str__(self) -> str:
        return render(self)


Node: TypeAlias = "Element | Verbatim | str | int | float | Iterable[Node] | None"
"""What an element may hold: elements, text, lists of such; None is nothing."""


def element(tag: str, /, *children: Node, **attributes: Any) -> Element:
    """An element. `class_` stands for `class`, `data_name` for `data-name`; True is a bare attribute, None none."""
    return Element(tag, attributes, children)


def prose(text: str) -> list[Node]:
    """A sentence in which what stands between backticks is code."""
    return [element("code", part) if number % 2 else part for number, part in enumerate(text.split("`"))]


def render(node: Node) -> str:
    """The markup."""
    return "".join(_pieces(node))


def style(*texts: str) -> Element:
    """Style sheets of our own."""
    return element("style", _closed("\n".join(texts), "style"))


def script(*texts: str) -> Element:
    """Scripts of our own."""
    return element("script", _closed("\n".join(texts), "script"))


def data_block(name: str, content: Any) -> Element:
    """Data for scripts and for other programs: JSON in which nothing can end the element."""
    text = json.dumps(content, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    for mark in "<>&":
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return element("script", Verbatim(text), type="application/json", id=name)


def _closed(text: str, tag: str) -> Verbatim:
    if f"</{tag}" in text.lower():
        raise ValueError(f"a {tag} cannot hold its own end tag")
    return Verbatim(text)


def _pieces(node: Node) -> Iterator[str]:
    if node is None:
        return
    if isinstance(node, Element):
        yield from _element(node)
    elif isinstance(node, Verbatim):
        yield node.text
    elif isinstance(node, str | int | float):
        yield escape(_clean(str(node)), quote=False)
    else:
        for child in node:
            yield from _pieces(child)


def _element(node: Element) -> Iterator[str]:
    yield f"<{node.tag}"
    for name, value in node.attributes.items():
        if value is not None and value is not False:
            yield _attribute(name.rstrip("_").replace("_", "-"), value)
    yield ">"
    if node.tag not in VOID:
        yield from _pieces(node.children)
        yield f"</{node.tag}>"


def _attribute(name: str, value: Any) -> str:
    return f" {name}" if value is True else f' {name}="{escape(_clean(str(value)))}"'


def _clean(text: str) -> str:
    return UNPRINTABLE.sub("\ufffd", text)
