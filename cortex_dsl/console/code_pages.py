"""`cortexc explain [CODE]`: the page of a code, or all codes by family."""

import argparse
from typing import TYPE_CHECKING

from cortex_dsl.console.command import Command, Option
from cortex_dsl.console.terminal import Exit, Terminal, UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from cortex_dsl.codes import Entry, Page
    from cortex_dsl.diagnostics import Diagnostic
    from cortex_dsl.source import Source


SHOWN_LINES = 20
"""Lines of an example that are shown at most."""
MARGIN = "    "


def _explain(options: argparse.Namespace, terminal: Terminal) -> Exit:
    if not options.code:
        _list(options.json, terminal)
    else:
        _show(_found(options.code[0]), options.json, terminal)
    return Exit.FINE


def _found(text: str) -> "Entry":
    from cortex_dsl import codes

    entry = codes.find(text)
    if entry is None:
        near = ", ".join(f"{each.code} ({each.title})" for each in codes.near(text))
        raise UsageError(
            f"there is no code `{text}`", f"near it: {near}" if near else "`cortexc explain` lists all codes"
        )
    return entry


# -- all codes --------------------------------------------------------------------------------------------------------


def _list(json: bool, terminal: Terminal) -> None:
    from cortex_dsl import codes

    entries = codes.entries()
    if json:
        terminal.document("codes", {"codes": [_summary(entry) for entry in entries]})
        return
    for number, family in codes.FAMILIES.items():
        terminal.out.print(f"{'' if number == '1' else chr(10)}SCN{number}xx  {family}", style="title")
        for entry in (entry for entry in entries if entry.code[3] == number):
            kind = "" if entry.severity.value == "error" else f" ({entry.severity.value})"
            terminal.out.print(f"  {entry.code}  {entry.title}", end="")
            terminal.out.print(kind, style="quiet")
    terminal.out.print("\n`cortexc explain CODE` shows more about one of them.", style="quiet")


def _summary(entry: "Entry") -> dict[str, object]:
    return {"code": entry.code, "severity": entry.severity, "family": entry.family, "title": entry.title}


# -- one code ---------------------------------------------------------------------------------------------------------


def _show(entry: "Entry", json: bool, terminal: Terminal) -> None:
    from cortex_dsl.report.findings.snippet import as_json
    from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics

    page = entry.page
    source, said = _said(entry.code, page)
    if json:
        terminal.document("code", {**_summary(entry), **_content(page), "says": as_json(source, said)})
        return
    out = terminal.out
    out.print(f"{entry.code} ({entry.severity.value}): {page.title}\n", style="title", soft_wrap=True)
    out.print(page.why)
    if page.shown:
        out.print(f"It is said {page.shown}.")
    _program(out, "For example", page.wrong, page.options[0])
    if said:
        out.print()
        print_diagnostics(source, said, out)
    _program(out, "Corrected", page.right, page.options[1])


def _content(page: "Page") -> dict[str, object]:
    return {
        "why": page.why,
        "shown": page.shown,
        "wrong": {"text": page.wrong, "option": page.options[0]},
        "right": {"text": page.right, "option": page.options[1]},
    }


def _program(out: "Console", heading: str, text: str, option: str) -> None:
    if not text:
        return
    from cortex_dsl.plain_text import visible

    out.print(f"\n{heading}{f', with `-p {option!r}`' if option else ''}:\n", style="title", soft_wrap=True)
    lines = text.splitlines()
    for line in lines[:SHOWN_LINES]:
        shown = visible(line)
        out.print(MARGIN + (shown if len(shown) <= out.width - 8 else shown[: out.width - 9] + "…"), soft_wrap=True)
    if len(lines) > SHOWN_LINES:
        out.print(f"{MARGIN}… ({len(lines) - SHOWN_LINES} more lines)", style="quiet")


def _said(code: str, page: "Page") -> tuple["Source", list["Diagnostic"]]:
    """Return the source of the wrong example and the compiler's diagnostic with this code."""
    from cortex_dsl.codes import judged
    from cortex_dsl.source import Source

    if page.shown:
        return Source("example.scn", page.wrong), []
    source, diagnostics = judged("example.scn", page.wrong, page.options[0])
    return source, [diagnostic for diagnostic in diagnostics if diagnostic.code == code][:1]


# -- the command -------------------------------------------------------------------------------------------------------


EXPLAIN = Command(
    name="explain",
    usage="[CODE] [--json]",
    description="What a code means: its reason, an example, and the example corrected. Without CODE: all codes.",
    options=(Option("code", "such as SCN203, scn203 or 203", "CODE", nargs="*"),),
    function=_explain,
    layout=argparse.HelpFormatter,
)
