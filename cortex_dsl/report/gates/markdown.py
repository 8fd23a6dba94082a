"""The result of `cortexc test` as Markdown: a table of the files, then each failure.

GitHub takes at most 1 MiB from a step. The shortest failures come first, so that a long one is left out before others.
"""

import re
from collections.abc import Iterable, Iterator

from cortex_dsl.plain_text import visible
from cortex_dsl.report.findings.gate_report import Check, FileResult, GateReport, Status
from engine.display import counted

LARGEST = 1 << 20
"""Largest size of a summary [bytes]."""
ROOM = 300
"""Bytes that stay free for the line that counts what is left out."""
SIGNS = {
    Status.PASS: "✅ pass",
    Status.KNOWN: "🔶 known",
    Status.UNDECIDED: "❔ undecided",
    Status.FAIL: "❌ FAIL",
    Status.ERROR: "🛑 error",
}


def markdown_text(report: GateReport, largest: int = LARGEST) -> str:
    """Return the summary, of at most `largest` bytes; troubled files come first in the table."""
    head = f"### cortexc test: {report.headline}\n\n"
    files = sorted(report.files, key=lambda file: (file.status is Status.PASS, file.path))
    table = "| | file | runs | limits |\n|---|---|---|---|\n"
    found = report.checks(Status.FAIL, Status.UNDECIDED, Status.KNOWN)
    failures = sorted((_failure(file, check) for file, check in found), key=lambda text: (len(text), text))
    text = _filled(head + table, (_row(file) for file in files), "file", largest)
    return _filled(f"{text}\n", failures, "failure", largest)


def _filled(text: str, parts: Iterable[str], noun: str, largest: int) -> str:
    """Return a text with as many parts as fit, and a line that counts the others."""
    size, left = len(text.encode()), 0
    for part in parts:
        size += len(part.encode())
        if left or size > largest - ROOM:
            left += 1
        else:
            text += part
    note = f"\n{counted(left, f'further {noun}')} left out, for the size of a summary\n" if left else ""
    return text + (note if len((text + note).encode()) <= largest else "")


def _row(file: FileResult) -> str:
    limits = file.trouble or "; ".join(f"{check.name}: {check.status}" for check in file.checks)
    return f"| {SIGNS[file.status]} | {_cell(file.path)} | {file.runs:,} | {_cell(limits)} |\n"


def _failure(file: FileResult, check: Check) -> str:
    place = f"{check.place or file.path}{f':{check.line}' if check.line else ''}"
    lines = [f"**{_cell(check.name)}** in {_cell(place)}: {check.status}, {_cell(check.text)}"]
    if check.first is not None:
        lines += [_cell(check.first.text), "", *_code(check.replay)]
    return "\n".join([*lines, "", ""])


def _code(text: str) -> Iterator[str]:
    """Yield a block of code whose fence the text does not contain."""
    longest = max((len(found) for found in re.findall(r"`+", text)), default=0)
    fence = "`" * max(3, longest + 1)
    yield from (f"{fence}sh", visible(text), fence)


def _cell(text: str) -> str:
    """Return a text that Markdown shows as it is, on one line."""
    line = " ".join(visible(text).split())
    return re.sub(r"([\\`*_{}\[\]<>#|&~])", r"\\\1", line)
