"""`cortexc fmt FILES`: format files; with --check, list those to change, with --diff, show the changes."""

import argparse
import difflib
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cortex_dsl.console.command import Command, Option
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import is_folder, read_bytes, write_bytes
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.syntax.errors import MAX_BYTES
from cortex_dsl.syntax.formatting import format_source
from cortex_dsl.syntax.reading import decode_text
from cortex_dsl.syntax.scenic2 import in_scenic_3

STDIN = "-"


@dataclass(frozen=True)
class _Text:
    """A file's text as it is and as it should be."""

    name: str
    before: str
    after: str

    @property
    def changed(self) -> bool:
        return self.before != self.after


def _fmt(options: argparse.Namespace, terminal: Terminal) -> Exit:
    if STDIN in options.files:
        if len(options.files) > 1:
            raise UsageError("`-` stands alone", "format the other files in a command of their own")
        return _stdin(options, terminal)
    return _files(options, terminal)


# -- stdin and files ---------------------------------------------------------------------------------------------------


def _stdin(options: argparse.Namespace, terminal: Terminal) -> Exit:
    try:
        text = _formatted("<stdin>", sys.stdin.buffer.read(MAX_BYTES + 1), options)
    except CompileError as error:
        _show(error, terminal)
        return Exit.DIAGNOSTICS
    if options.check or options.diff:
        return _report(text, options, terminal)
    sys.stdout.flush()
    sys.stdout.buffer.write(text.after.encode())
    return Exit.FINE


def _files(options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Format every file; return the worst of the exit codes."""
    worst, changed, unchanged = Exit.FINE, 0, 0
    for path in _paths(options.files):
        try:
            text = _formatted(str(path), read_bytes(path), options)
            worst = max(worst, _finish(path, text, options, terminal))
        except CompileError as error:
            _show(error, terminal)
            worst = max(worst, Exit.DIAGNOSTICS)
        except UsageError as error:
            terminal.complain(error.message, error.cure)
            worst = Exit.USAGE
        else:
            changed, unchanged = changed + text.changed, unchanged + (not text.changed)
    if not options.diff:
        _summary(changed, unchanged, options.check, terminal)
    return worst


def _paths(names: Sequence[str]) -> Iterator[Path]:
    """The files that were named and those below the folders that were, each once."""
    found: dict[Path, None] = {}
    for path in map(Path, names):
        below = list(_below(path)) if is_folder(path) else [path]
        if not below:
            raise UsageError(f"there is no scenario below `{path}`", "scenario files end in .scn")
        found.update(dict.fromkeys(below))
    yield from found


def _below(folder: Path) -> Iterator[Path]:
    """Yield the scenarios below a folder, except those in hidden folders.

    Raises:
        UsageError: it is inaccessible.
    """
    if not os.access(folder, os.R_OK | os.X_OK):
        raise UsageError(f"cannot read the folder `{folder}`: permission denied")
    for path in sorted(folder.rglob("*.scn")):
        hidden = any(part.startswith(".") for part in path.relative_to(folder).parts)
        if path.is_file() and not hidden:
            yield path


def _formatted(name: str, content: bytes, options: argparse.Namespace) -> _Text:
    """Return a file's formatted text, with its byte order mark if it has one; `--from` names the language of the file.

    Raises:
        CompileError: it is no text, or does not parse.
    """
    source = decode_text(name, content)
    mark = "\ufeff" if content.startswith(b"\xef\xbb\xbf") else ""
    wanted = replace(source, text=in_scenic_3(source.text)) if options.written_in == "scenic2" else source
    return _Text(name, mark + source.text, mark + format_source(wanted))


def _finish(path: Path, text: _Text, options: argparse.Namespace, terminal: Terminal) -> Exit:
    if options.check or options.diff:
        return _report(text, options, terminal)
    if text.changed:
        write_bytes(path, text.after.encode())
        terminal.out.print(f"formatted {text.name}", soft_wrap=True)
    return Exit.FINE


def _report(text: _Text, options: argparse.Namespace, terminal: Terminal) -> Exit:
    """Print the change of a text and return the exit code."""
    if text.changed and options.diff:
        terminal.write(_diff(text), coloured=not sys.stdout.isatty())  # for `patch`, byte for byte
    elif text.changed:
        terminal.out.print(f"would change {text.name}", soft_wrap=True)
    return Exit.DIAGNOSTICS if text.changed and options.check else Exit.FINE


def _diff(text: _Text) -> str:
    before, after = text.before.splitlines(), text.after.splitlines()
    if before == after:
        return f"--- {text.name}\n+++ {text.name}\n(line breaks alone)"
    return "\n".join(difflib.unified_diff(before, after, text.name, text.name, lineterm=""))


def _summary(changed: int, unchanged: int, checked: bool, terminal: Terminal) -> None:
    parts = [f"{counted(changed, 'file')} {'would change' if checked else 'formatted'}"] if changed else []
    parts += [f"{counted(unchanged, 'file')} fine already"] if unchanged else []
    if parts:
        terminal.out.print(", ".join(parts), style="quiet", soft_wrap=True)


def _show(error: CompileError, terminal: Terminal) -> None:
    from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics

    print_diagnostics(error.source, error.diagnostics, terminal.err)
    sys.stderr.flush()


# -- the command -------------------------------------------------------------------------------------------------------


FMT = Command(
    name="fmt",
    usage="FILES [--check] [--diff] [--from scenic2]",
    description="Put scenario files into the standard layout. Comments and meaning stay the same.",
    options=(
        Option(
            "files",
            "files, folders (all *.scn below), or `-` for stdin",
            "FILES",
            nargs="*",
            missing=("no files to format", "name files or folders, `.` for all below this one, or `-` for stdin"),
        ),
        Option(
            "--from", "rewrite scripts of Scenic 2: `new`, `():`, monitors", choices=("scenic2",), name="written_in"
        ),
        Option("--check", "write nothing; name the files that would change", default=False),
        Option("--diff", "write nothing; show what would change", default=False),
    ),
    function=_fmt,
    epilog="exit codes: 0 fine, 1 a file has errors (or, with --check, would change), 2 a path cannot be used",
    json=False,
    layout=argparse.HelpFormatter,
)
