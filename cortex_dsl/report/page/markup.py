"""HTML and SVG as trees of elements, and the page around them.

Every text and every attribute is escaped, so that a name can do no harm. A page is one file with its style, its
scripts and its data inside, which needs no network.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from itertools import pairwise
from shlex import join
from string import Template
from typing import Any, TypeAlias

from engine.checksums import NO_CHECKSUM, with_checksum
from engine.search.store import without_folders
from engine.strict_json import json_text

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
    """One element with its contents."""

    tag: str
    attributes: Mapping[str, Any]
    children: tuple["Node", ...]

    def __str__(self) -> str:
        return render(self)


Node: TypeAlias = "Element | Verbatim | str | int | float | Iterable[Node] | None"
"""Contents of an element: elements, text, lists of them; None is nothing."""


def element(tag: str, /, *children: Node, **attributes: Any) -> Element:
    """An element. `class_` stands for `class`, `data_name` for `data-name`; True is a bare attribute, None none."""
    return Element(tag, attributes, children)


def prose(text: str) -> list[Node]:
    """Return the nodes of a sentence; text between backticks is code."""
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
    text = json_text(content, ascii_only=True, separators=(",", ":"))
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


# -- a page from its parts ---------------------------------------------------------------------------------------------


def page(
    title: str,
    body: Node,
    data: Mapping[str, Any] | None = None,
    scripts: Sequence[str] = (),
    journal: str = "",
    styles: Element | None = None,
) -> str:
    """Return the whole text of a page; `data` are blocks by the names under which `scripts` find them, `journal` is the
    last link of the journal from which the page is made (`engine.checksums`), `styles` replace the usual ones.
    """
    parts = {
        "checksum": NO_CHECKSUM,
        "journal": journal,
        "title": render(element("title", title)),
        "style": render(styles or stylesheet()),
        "body": render(body),
        "data": render([data_block(name, content) for name, content in (data or {}).items()]),
        "script": render([script(text(name)) for name in scripts]),
    }
    return with_checksum(Template(text("page.html")).substitute(parts)).decode()


def stylesheet() -> Element:
    """Return the styles of a page, in light and in dark."""
    return style(drawing_rules(), text("page.css"))


def drawing_rules() -> str:
    """The rules for drawings and charts, by themselves enough for an SVG."""
    dark = text("dark.css")
    return "\n".join(
        (
            text("drawing.css"),
            f'@media screen and (prefers-color-scheme: dark) {{ :root:not([data-theme="light"]) {{\n{dark}}} }}',
            f':root[data-theme="dark"] {{\n{dark}}}',
        )
    )


def picture(drawing: Element, rules: str | None = None) -> str:
    """A drawing as an SVG of its own, with its style inside; without `rules` it is light for every reader."""
    attributes = {**drawing.attributes, "class_": f"{drawing.attributes.get('class_', '')} alone".strip()}
    return render(Element(drawing.tag, attributes, (style(rules or text("drawing.css")), *drawing.children)))


@cache
def text(name: str) -> str:
    """Return the text of a file in this folder."""
    return files("cortex_dsl.report.page").joinpath(name).read_text(encoding="utf-8")


# -- common parts of all pages -----------------------------------------------------------------------------------------


def part(name: str, title: str, note: Node, *content: Node) -> Element:
    """A section of a page."""
    return element(
        "section",
        element("h2", title),
        None if note is None else element("p", prose(note) if isinstance(note, str) else note, class_="note"),
        content,
        id=name,
        class_="part",
    )


def folded(summary: str, *content: Node) -> Element:
    """Return contents that a page shows on demand; a text is a note."""
    inner = [element("p", prose(each), class_="note") if isinstance(each, str) else each for each in content]
    return element("details", element("summary", summary), inner)


def table(head: Sequence[str] | None, rows: Sequence[Element], name: str) -> Element:
    """Return a table, with a head unless it is None, that scrolls by itself where the screen is narrow."""
    top = None
    if head is not None:
        cells = rows[0].children if rows and len(rows[0].children) == len(head) else (None,) * len(head)
        top = element("thead", element("tr", [_head(text, cell) for text, cell in zip(head, cells, strict=True)]))
    return element("div", element("table", top, element("tbody", rows), class_=name), class_="wide", tabindex=0)


def _head(text: str, below: Node) -> Element:
    """Over numbers, to the right like them."""
    numbers = isinstance(below, Element) and "number" in str(below.attributes.get("class_")).split()
    return element("th", text, scope="col", class_="number" if numbers else None)


def top_bar(links: Sequence[tuple[str, str]]) -> Element:
    """The line at the top of a page, with places in it."""
    return element(
        "nav",
        element(
            "div",
            element("span", "cortexc", class_="brand"),
            [element("a", name, href=place) for place, name in links],
            element("button", "dark", type="button", class_="theme", title="light or dark"),
            class_="top",
        ),
        class_="bar-top",
    )


def figure(name: str, value: float, text: str) -> Node:
    """A number as people read it, with its exact value for programs; `name` says where the journal has it."""
    return element("data", text, value=repr(value), data_figure=name)


# -- commands ----------------------------------------------------------------------------------------------------------


def command_again(words: Sequence[str]) -> str:
    """Return the command line for repeating a command, without the results folder: it exists and would be refused."""
    after_out = {k for k, pair in enumerate(pairwise(words), start=1) if pair[0] == "--out"}
    remaining = [word for k, word in enumerate(words) if k not in after_out and word.partition("=")[0] != "--out"]
    return join(("cortexc", *map(without_folders, remaining)))
