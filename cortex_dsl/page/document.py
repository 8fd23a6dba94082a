"""A page from its parts: one file with its style, its scripts and its data inside, which needs no network."""

from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from string import Template
from typing import Any

from cortex_dsl.page.element import Element, Node, data_block, element, prose, render, script, style


def page(title: str, body: Node, data: Mapping[str, Any] | None = None, scripts: Sequence[str] = ()) -> str:
    """The whole text of a page; `data` are blocks by the names under which `scripts` find them."""
    parts = {
        "title": render(element("title", title)),
        "style": render(stylesheet()),
        "body": render(body),
        "data": render([data_block(name, content) for name, content in (data or {}).items()]),
        "script": render([script(text(name)) for name in scripts]),
    }
    return Template(text("page.html")).substitute(parts)


def stylesheet() -> Element:
    """Everything that a page looks like, in light and in dark."""
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


def picture(drawing: Element) -> str:
    """A drawing as an SVG of its own, with its style inside."""
    attributes = {**drawing.attributes, "class_": f"{drawing.attributes.get('class_', '')} alone".strip()}
    return render(Element(drawing.tag, attributes, (style(text("drawing.css")), *drawing.children)))


@cache
def text(name: str) -> str:
    """One of the files beside this module."""
    return files("cortex_dsl.page").joinpath(name).read_text(encoding="utf-8")


def part(name: str, title: str, note: Node, *content: Node) -> Element:
    """A section of a page."""
    return element(
        "section",
        element("h2", title),
        element("p", prose(note) if isinstance(note, str) else note, class_="note"),
        content,
        id=name,
        class_="part",
    )


def table(head: Sequence[str], rows: Sequence[Element], name: str) -> Element:
    """A table with a head, which scrolls by itself where the screen is narrow."""
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
