"""A page from its parts: one file with its style, its scripts and its data inside, which needs no network."""

from collections.abc import Mapping, Sequence
from functools import cache
from importlib.resources import files
from string import Template
from typing import Any

from cortex_dsl.page.element import Element, Node, data_block, element, render, script, style


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
