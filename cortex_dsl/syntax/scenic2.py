"""Scripts of Scenic 2 in the spelling of Scenic 3: objects are made with `new`, behaviors and monitors have brackets,
and a monitor runs because it is required.

Source: Scenic 3 documentation, "What's New in Scenic", backwards incompatible syntax changes.
"""

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from shlex import quote

from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.source import Source
from cortex_dsl.syntax import errors
from cortex_dsl.syntax.scanning import Line, scan
from cortex_dsl.syntax.words import RESERVED, SPECIFIER_WORDS

COMMAND = "cortexc fmt --from scenic2"
MOST_LINES = 8
"""Lines that are named."""
MOST_FORGOTTEN = 1
"""Errors of the spelling of Scenic 2 that a file may have without being such a script."""

_SKIPPED = r"#[^\n]*|\"\"\"[\s\S]*?\"\"\"|'''[\s\S]*?'''|\"(?:[^\"\\\n]|\\.)*\"|'(?:[^'\\\n]|\\.)*'"
_HEAD = re.compile(r"(?P<kind>behavior|monitor)[ \t]+(?P<name>\w+)[ \t]*(?P<colon>:)")
_SPECIFIED = re.compile(rf"[ \t]+(?:{'|'.join(sorted(SPECIFIER_WORDS))})\b")
_MADE = re.compile(rf"(?P<skipped>{_SKIPPED})|(?<![\w.])(?P<name>[A-Z]\w*)\b")
_WHOLE = re.compile(r"(?:[^\W\d]\w*[ \t]*=[ \t]*|return[ \t]+)?\Z")
"""Pattern of the text before a class that is the whole value of a statement."""
_ASSIGNED = re.compile(r"^[ \t]*([^\W\d]\w*)[ \t]*=", re.MULTILINE)
_BEFORE = re.compile(r"\b(?:new|class)[ \t]+\Z")


def in_scenic_3(text: str) -> str:
    """Return the text of a script in the spelling of Scenic 3; correct parts are unchanged."""
    lines = scan(text).lines
    values = {*RESERVED, *_ASSIGNED.findall(text)}
    edits = sorted(edit for line in lines for edit in (*_brackets(text, line), *_objects(text, line, values)))
    definitions = filter(None, (_HEAD.match(text, line.start) for line in lines))
    monitors = [found["name"] for found in definitions if found["kind"] == "monitor"]
    done, end = "", 0
    for place, inserted in edits:
        done, end = done + text[end:place] + inserted, place
    required = (f"require monitor {name}()\n" for name in monitors if f"require monitor {name}" not in text)
    done += text[end:]
    return done + "".join(("" if done.endswith("\n") or not monitors else "\n", *required))


def _brackets(text: str, line: Line) -> Iterator[tuple[int, str]]:
    if (found := _HEAD.match(text, line.start)) is not None:
        yield found.start("colon"), "()"


def _objects(text: str, line: Line, values: Collection[str]) -> Iterator[tuple[int, str]]:
    """Yield the places before classes from which a statement makes objects: with specifiers after them, or alone.

    Names of values are no classes.
    """
    for found in _MADE.finditer(text, line.start, line.end):
        name = found["name"]
        if name is None or name.isupper() or name in values or _BEFORE.search(text, line.start, found.start()):
            continue
        alone = found.end() == line.end and _WHOLE.match(text, line.start, found.start())
        specified = _SPECIFIED.match(text, found.end(), line.end)
        if alone or specified:
            yield found.start(), "new "


def in_one(diagnostics: Sequence[Diagnostic], source: Source) -> list[Diagnostic]:
    """Return the diagnostics with those of the spelling of Scenic 2 merged.

    The merged diagnostic names their lines and the command.
    """
    spelled = [
        each for each in diagnostics if each.code == errors.MISSING_NEW.code or each.cure == errors.WRITE_BRACKETS
    ]
    if len(spelled) <= MOST_FORGOTTEN:
        return list(diagnostics)
    first, *others = spelled
    numbers = list(dict.fromkeys(str(source.position(each.label.span.start).line) for each in others))
    shown, more = ", ".join(numbers[:MOST_LINES]), len(numbers) - MOST_LINES
    tail = f" and {more} more" if more > 0 else ""
    also = f"The spelling of Scenic 2 is also in line{'s' * (len(numbers) > 1)} {shown}{tail}."
    whole = replace(
        first,
        reason=f"{first.reason} {also}".strip(),
        cure=f"{first.cure}; `{COMMAND} {quote(source.name)}` rewrites a whole script of Scenic 2",
    )
    return [whole if each is first else each for each in diagnostics if each is first or each not in others]
