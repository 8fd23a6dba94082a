"""`cortexc export RUN --case K --to xosc` and `cortexc export FILE.scn --to xosc`: cases for other people's tools."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from shlex import join, split
from typing import TYPE_CHECKING, Any

from cortex_dsl.console.cases import (
    CASE,
    OF_RUN,
    OF_SCENARIO,
    SEED_OF_SCENE,
    is_scenario,
    known_formats,
    run_or_scenario,
    write_cases,
)
from cortex_dsl.console.command import DRIVER, PARAM, SCENARIO, Command, Condition, Option, driver_words, excluded_by
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.interchange.formats import FORMATS, RECORDINGS, checked_of, missing_extra
from engine.errors import InterchangeError
from engine.interchange.contract import AFTER_CONTACT, MODES, OSC_VERSIONS, PLAYERS, ExportOptions, Finding

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from cortex_dsl.report.findings.interchange_report import Gathered

FOLDER = "exports"
"""Folder of exported files without --out: inside the run's folder, or the working folder."""
MOST_CASES = 1_000
"""Maximum of --top; all files of these cases are in memory before the first is written."""
LIST = "list"


def _export(options: argparse.Namespace, terminal: Terminal) -> int:
    if options.to is None and options.player is None:
        raise UsageError("export to what? name one or more formats", f"--to {','.join(FORMATS)}")
    formats = options.to or ("xosc",)
    if options.what.suffix.lower() in RECORDINGS:
        raise UsageError(
            f"`{options.what}` is a recording already", f"`cortexc measure {options.what}` shows its metrics and risk"
        )
    is_file = is_scenario(options.what)
    cases = _of_file(options, terminal) if is_file else _of_run(options, terminal)
    if isinstance(cases, int):
        return cases
    folder = options.out or (Path(FOLDER) if is_file else _home(options.what) / FOLDER)
    return _write(cases, formats, folder, options, terminal)


def _answer(options: argparse.Namespace) -> str:
    """Return the list of formats for `--to list`, or its document."""
    if options.to != (LIST,):
        return ""
    if not options.json:
        return format_list()
    from cortex_dsl.report.documents import document

    return document("formats", {"formats": _formats_content(), "diagnostics": [], "notes": []})


def format_list() -> str:
    """Return a table of formats: name, contents, readers, and whether its package is missing."""
    width = max(map(len, FORMATS))
    lines = []
    for name, entry in FORMATS.items():
        lines += [f"{name:<{width}}  {entry.summary}"]
        lines += [f"{'':<{width}}  {text}" for text in (", ".join(entry.suffixes), f"for {entry.readers}")]
        if cure := missing_extra(name):
            lines += [f"{'':<{width}}  not installed; to have it:", f"{'':<{width}}    {cure}"]
    return "\n".join(lines)


def _formats_content() -> list[dict[str, Any]]:
    """Return the formats for the document of --json."""
    return [
        {"name": name, "suffixes": entry.suffixes, "summary": entry.summary, "readers": entry.readers}
        | {"installed": not missing_extra(name)}
        for name, entry in FORMATS.items()
    ]


def _formats(text: str) -> tuple[str, ...]:
    """Return each format once, in the order of the list; the word `list` stays as it is."""
    return (text,) if text == LIST else known_formats(text.split(","), "--to: ")


def _home(path: Path) -> Path:
    """The folder of a run that may be named by its journal."""
    return path if path.is_dir() else path.parent


# -- the cases --------------------------------------------------------------------------------------------------------


def _of_run(options: argparse.Namespace, terminal: Terminal) -> "list[ExportCase]":
    """Case K of a run, or its first N."""
    from cortex_dsl.cli.search_output import cases_of, opened_run, usage_errors
    from cortex_dsl.interchange.cases import case_of_run

    run = opened_run(options.what, terminal, json=options.json)
    if not len(run.record.evaluations):
        raise UsageError(f"`{options.what}` has no finished generation", "`cortexc resume` goes on with it")
    case = cases_of(run, options.what, options.case)[options.case - 1]
    chosen = (case,) if options.top is None else run.first_cases(options.top)
    with usage_errors():
        return [case_of_run(run, case) for case in chosen]


def _of_file(options: argparse.Namespace, terminal: Terminal) -> "list[ExportCase] | int":
    """The scene that `cortexc FILE.scn` shows, which may be invalid or fail."""
    from cortex_dsl.cli.draw_modes import drawn_scene
    from cortex_dsl.interchange.cases import case_of_scene
    from engine.search.store import without_folders
    from engine.vocabulary import Verdict

    words = _scene_words(options)
    drawn = drawn_scene([*words, *(["--json"] if options.json else [])], terminal)
    if isinstance(drawn, Exit):
        return drawn
    pinned = drawn.scenario.program.settings.stream is not None and options.seed is None
    seed = None if pinned else options.seed or 0
    again = join(["cortexc", *words, *([] if options.seed is not None or pinned else ["--seed", "0"])])
    portable = join(map(without_folders, split(again)))
    case = case_of_scene(drawn.scenario, drawn.scenes, options.what, seed, portable)
    if case.outcomes.verdict[0] == Verdict.ERROR:
        raise UsageError(f"the run of `{options.what}` fails", f"`{again}` says why")
    return [case]


def _scene_words(options: argparse.Namespace) -> list[str]:
    """The command line that shows the scene of a file."""
    params = [word for name, value in options.overrides.items() for word in ("-p", f"{name}={value}")]
    scenario = [] if options.scenario is None else ["--scenario", options.scenario]
    seed = [] if options.seed is None else ["--seed", str(options.seed)]
    driver = driver_words(options.ego, options.ego_batch, options.ego_observes)
    return [as_word(options.what), *scenario, *params, *seed, *driver]


def as_word(path: Path) -> str:
    """Return the path as one types it: "./" goes before a name that begins like an option."""
    return f"./{path}" if str(path).startswith("-") else str(path)


# -- their files ------------------------------------------------------------------------------------------------------


def _write(
    cases: "Sequence[ExportCase]",
    formats: Sequence[str],
    folder: Path,
    options: argparse.Namespace,
    terminal: Terminal,
) -> int:
    from cortex_dsl.report.findings.interchange_report import export_content
    from cortex_dsl.report.terminal.export_view import export_view

    usual = "1.2" if options.player is None else "1.0"
    try:
        how = ExportOptions(options.osc or usual, options.mode or "trajectory", options.player, options.after_contact)
    except InterchangeError as error:
        raise UsageError(error.message, error.cure) from None
    esmini = None if options.checking is None else esmini_named(options.esmini)
    written = write_cases(cases, formats, folder, how, force=options.force, esmini=esmini)
    gathered = written.gathered
    formats = [name for name in formats if name not in gathered.refused]
    findings = _findings(cases, gathered, formats, folder, how) if options.check else None
    if findings is not None:
        findings += [finding for each in written.certificates for finding in each.findings]
    checked = {name: checked_of(name, how.mode) for name in formats} if options.check else {}
    written = replace(written, findings=findings, checked=checked)
    if options.json:
        terminal.document("export", export_content(written, how))
    else:
        terminal.out.print(export_view(written, how))
    for error in gathered.refused.values():
        terminal.complain(f"{error.place}: {error.message}", error.cure)
    return Exit.DIAGNOSTICS if findings else Exit.USAGE if gathered.refused else Exit.FINE


def esmini_named(path: Path | None) -> Path:
    """Return the library that plays the written files.

    Raises:
        UsageError: there is no library.
    """
    from engine.interchange.esmini import esmini_library

    try:
        return esmini_library(path)
    except InterchangeError as error:
        raise UsageError(error.message, error.cure) from None


def _findings(
    cases: "Sequence[ExportCase]", gathered: "Gathered", formats: Sequence[str], folder: Path, how: ExportOptions
) -> list[Finding]:
    findings: dict[Finding, None] = {}
    for case, names in zip(cases, gathered.names, strict=True):
        for name in formats:
            findings |= dict.fromkeys(FORMATS[name].load_checker()(case, folder, names, how))
    return list(findings)


XOSC = Condition("the format xosc", lambda options: "xosc" in (options.to or ("xosc",)), "add xosc to --to")
OSC = Option("--osc", f"version of OpenSCENARIO: {', '.join(OSC_VERSIONS)} (1.2)", "V", choices=OSC_VERSIONS)
OPTIONS = (
    run_or_scenario("export", "--to xosc"),
    replace(CASE, choice="case"),
    Option(
        "--top", "the worst N cases of the run", "N", whole_number(1, MOST_CASES), choice="top", excludes=(OF_SCENARIO,)
    ),
    SEED_OF_SCENE,
    *excluded_by(OF_RUN, PARAM, replace(SCENARIO, help="the scenario to run, where the file has several"), *DRIVER),
    Option("--to", "one or more formats, separated by commas; `list` shows all", "FORMATS", _formats, answer=_answer),
    replace(OSC, needs=(XOSC,)),
    Option(
        "--mode",
        "form of an xosc: trajectory, an exact replay, or maneuver, with speeds, routes and triggers (trajectory)",
        "HOW",
        choices=MODES,
        needs=(XOSC,),
    ),
    Option(
        "--for",
        "carla: an xosc, and a script that replays it exactly in CARLA",
        "PLAYER",
        choices=PLAYERS,
        name="player",
        needs=(XOSC,),
    ),
    Option(
        "--after-contact",
        "motion after contact: through, actors pass through each other (default of xosc), stop, or physics (default "
        "of all other formats)",
        "HOW",
        choices=AFTER_CONTACT,
    ),
    Option("--out", f"folder for the files (RUN/{FOLDER}, or {FOLDER})", "DIR", Path),
    Option("--force", "overwrite files that have other contents", default=False),
    Option("--check", "read the written files back and compare them with the run", default=False),
    Option(
        "--player",
        "with --check: let esmini play each xosc, and write a certificate of its fidelity",
        "NAME",
        choices=("esmini",),
        name="checking",
        needs=("check", XOSC),
    ),
    Option("--esmini", "path of the esmini library (CORTEXC_ESMINI)", "PATH", Path, needs=("checking",)),
)


def _readers() -> str:
    """Return each format, and its readers."""
    return "\n".join(f"  {name:<12}{entry.summary}\n{'':14}for {entry.readers}" for name, entry in FORMATS.items())


EXPORT = Command(
    name="export",
    usage="RUN [--case K | --top N] --to FORMATS [options]\nFILE.scn [--seed N] [-p NAME=VALUE] --to FORMATS [options]",
    description="Write a found case, or the scene of a scenario, for other tools. Everything that\n"
    "a tool needs is written into one folder; no existing file gets other contents.",
    options=OPTIONS,
    function=_export,
    epilog=f"formats:\n{_readers()}",
)
