"""Pages that the program writes of itself: its commands with their help, and its diagnostics with their examples.

Both come from `cortexc`: what a page says is what `cortexc NAME --help` and `cortexc explain CODE` print.
"""

import contextlib
import io
import json
import os
from collections.abc import Iterator
from functools import cache
from typing import Any

from cortex_dsl.cli import main
from cortex_dsl.cli.command_table import SUBCOMMANDS

Pages = dict[str, str]
"""Text of pages by their place in the site."""
COMMANDS = """\
# Commands

The output of `cortexc --help-all` and of `cortexc NAME --help`.
"""
DIAGNOSTICS = """\
# Diagnostics

Each mistake has a code that never changes. The page of a code says why, with the smallest file that shows it and the
same file mended; `cortexc explain CODE` prints it in the terminal. A comment `# allow CODE` in a file silences a
warning or a hint.
"""
BOXES = {"error": "failure", "warning": "warning"}
"""Kinds of boxes by severity."""


def said(*words: str) -> str:
    """What the command prints, 80 columns wide."""
    out = io.StringIO()
    before = os.environ.get("COLUMNS")
    os.environ["COLUMNS"] = "80"
    try:
        with contextlib.redirect_stdout(out):
            main(words)
    finally:
        os.environ.pop("COLUMNS") if before is None else os.environ.update(COLUMNS=before)
    return out.getvalue()


# -- commands ---------------------------------------------------------------------------------------------------------


def commands() -> str:
    """One page with every command and its help."""
    parts = [COMMANDS, _command("FILE", "", said("--help-all"))]
    parts += [_command(name, command.summary, said(name, "--help")) for name, command in SUBCOMMANDS.items()]
    return "\n".join(parts)


def _command(name: str, summary: str, text: str) -> str:
    sentence = f"{_plain(summary[0].upper() + summary[1:])}.\n\n" if summary else ""
    return f"## cortexc {name}\n\n{sentence}```text\n{text.rstrip()}\n```\n"


# -- diagnostics ------------------------------------------------------------------------------------------------------


@cache
def codes() -> list[dict[str, Any]]:
    """Every code, with family, severity and title."""
    return json.loads(said("explain", "--json"))["codes"]


def families() -> dict[str, list[dict[str, Any]]]:
    """Codes by the name of their family."""
    found: dict[str, list[dict[str, Any]]] = {}
    for code in codes():
        found.setdefault(code["family"], []).append(code)
    return found


def place(code: str) -> str:
    """Where the page of a code stands."""
    return f"reference/diagnostics/{code}.md"


@cache
def diagnostics() -> Pages:
    """The list of codes by family, and a page for each."""
    pages = {"reference/diagnostics/index.md": _index()}
    for code in codes():
        pages[place(code["code"])] = _page(json.loads(said("explain", code["code"], "--json")))
    return pages


def _index() -> str:
    lines = [DIAGNOSTICS]
    for family, found in families().items():
        lines += [f"\n## {family.capitalize()}\n", "| code | what | |", "|---|---|---|"]
        for code in found:
            name, severity = code["code"], code["severity"]
            lines.append(f"| [`{name}`]({name}.md) | {_plain(code['title'])} | {_badge(severity)} |")
    return "\n".join(lines) + "\n"


def _page(code: dict[str, Any]) -> str:
    """Why, the file that shows it, what is said, and the file mended."""
    parts = [
        f"---\ndescription: {json.dumps(code['title'])}\n---\n",
        f"# {code['code']}: {_plain(code['title'])}\n",
        f"{_badge(code['severity'])} · {code['family']}\n",
        f"{_plain(code['why'])}\n",
    ]
    if code["shown"]:
        parts.append(f"It is said {_plain(code['shown'])}.\n")
    parts += _example("The smallest file that shows it", code["wrong"])
    parts += [_message(each) for each in code["says"]]
    parts += _example("Mended", code["right"])
    return "\n".join(parts)


def _example(title: str, block: dict[str, str] | None) -> Iterator[str]:
    if block and block["text"]:
        option = f", with `-p {block['option']}`" if block["option"] else ""
        yield f"## {title}{option}\n"
        yield f"```scn\n{block['text'].rstrip()}\n```\n"


def _message(said: dict[str, Any]) -> str:
    """A diagnostic as a box under the file, with its place."""
    title = _plain(said["message"]).replace('"', "&quot;")
    where = f"line {said['start']['line']}, column {said['start']['column']}"
    lines = [f'!!! {BOXES.get(said["severity"], "tip")} "{said["severity"]}, {where}: {title}"\n']
    lines += [f"    {_plain(said[part])}\n" for part in ("reason", "cure") if said[part]]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """A sentence of the program, none of whose signs means anything to Markdown outside of code marks."""
    parts = text.replace("\n", " ").split("`")
    for index in range(0, len(parts), 2):
        for sign in "*_<>|[]":
            parts[index] = parts[index].replace(sign, f"&#{ord(sign)};")
    return "`".join(parts)


def _badge(severity: str) -> str:
    return f'<span class="badge {severity}">{severity}</span>'
