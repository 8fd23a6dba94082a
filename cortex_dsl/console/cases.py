"""A case again, in the terminal or as files: shared by `cortexc replay`, `cortexc export` and the session."""

import argparse
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.command import EXAMPLE_RUN, SEED, Condition, Option, excluded_by
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Terminal, UsageError
from cortex_dsl.console.user_files import FLAGS, OverwriteFlags, is_folder, place_files
from cortex_dsl.interchange.formats import FORMATS, PLAYED_BY_CARLA, RECORDINGS, missing_extra
from cortex_dsl.shipped import SUFFIX
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from cortex_dsl.interchange.cases import ExportCase
    from cortex_dsl.interchange.formats import Gathered
    from cortex_dsl.report.findings.case_replay import CaseReplay
    from cortex_dsl.report.findings.interchange_report import Written
    from engine.interchange.contract import ExportOptions
    from engine.interchange.esmini.fidelity import Certificate
    from engine.search.ranking import Case

# -- options: a case of a run, or the scene of a scenario --------------------------------------------------------------


def is_scenario(path: Path) -> bool:
    """Return True for the file of a scenario, False for a run or a recording."""
    return path.suffix == SUFFIX and not is_folder(path)


OF_SCENARIO = Condition("a scenario, which has no cases", lambda options: is_scenario(options.what))
OF_RUN = Condition(
    "a run, whose cases have scenes and decisions of their own",
    lambda options: not is_scenario(options.what) and options.what.suffix.lower() not in RECORDINGS,
    "name a case with --case K",
)
CASE = Option(
    "--case", "case of the run; 1 is the worst", "K", whole_number(1, 10_000_000), default=1, excludes=(OF_SCENARIO,)
)
(SEED_OF_SCENE,) = excluded_by(OF_RUN, replace(SEED, help="seed of the scene of a scenario (0)"))


def run_or_scenario(command: str, example: str) -> Option:
    """Return the argument of a command; `example`: options after the folder of a run."""
    missing = (f"{command} what? name a run or a scenario", f"cortexc {command} {EXAMPLE_RUN} {example}")
    return Option("what", "folder of a run, or a scenario", "RUN|FILE.scn", Path, nargs="?", missing=missing)


# -- watched -----------------------------------------------------------------------------------------------------------

PICTURES = (".html", ".gif", ".svg")
"""Suffixes of a replay in a file: a page, a film, a picture."""


def play_case(shown: "CaseReplay", speed: float, terminal: Terminal) -> None:
    """Play a case in the terminal; Ctrl-C ends the film alone."""
    from cortex_dsl.report.terminal.replay_view import play

    try:
        play(shown, terminal.out, speed)
    except KeyboardInterrupt:
        terminal.out.print()


def picture(
    shown: "CaseReplay", path: Path, speed: float = 1.0, case: "Case | None" = None, folder: Path | None = None
) -> str | bytes:
    """Return the contents of a file with one of the suffixes of `PICTURES`.

    Raises:
        UsageError: a film needs a package that is not installed.
    """
    from engine.extras import MissingExtraError

    if path.suffix.lower() == ".html":
        from cortex_dsl.report.page.case_page import case_page

        return case_page(shown, case, folder)
    if path.suffix.lower() == ".svg":
        from cortex_dsl.report.page.player import key_picture

        return key_picture(shown)
    from cortex_dsl.report.page.film import gif

    try:
        return gif(shown, speed)
    except MissingExtraError as error:
        raise UsageError(error.message, error.cure) from None


def pace(text: str) -> float:
    """Parse the speed of a replay relative to real time: `2`, `0.25`, `4x`."""
    try:
        value = float(text.rstrip("x×"))
    except ValueError:
        value = float("nan")
    if not 0.01 <= value <= 100.0:
        raise argparse.ArgumentTypeError(f"must be a factor between 0.01 and 100, not `{text}`")
    return value


# -- written for other tools -------------------------------------------------------------------------------------------


def known_formats(words: Iterable[str], flag: str = "") -> tuple[str, ...]:
    """Each format once, in the order in which they are named; `flag` is where.

    Raises:
        UsageError: there is no such format, or none of them has the package that it needs.
    """
    names = tuple(dict.fromkeys(word.strip().removeprefix(".").lower() for word in words))
    for name in names:
        if name not in FORMATS:
            near = nearest(name, FORMATS)
            cure = f"did you mean `{near}`?" if near else f"name one or more of {', '.join(FORMATS)}"
            raise UsageError(f"{flag}there is no format `{name}`", cure)
    if names and all(map(missing_extra, names)):
        name = names[0]
        raise UsageError(
            f"{name} needs the package `{FORMATS[name].package}`, which is not installed", missing_extra(name)
        )
    return names


def write_cases(
    cases: "Sequence[ExportCase]",
    formats: Sequence[str],
    folder: Path,
    how: "ExportOptions",
    *,
    force: bool,
    flags: OverwriteFlags = FLAGS,
    esmini: Path | None = None,
) -> "Written":
    """Write all files of some cases, in every format that can represent all of them.

    With the library of `esmini`, each `.xosc` of a case gets its certificate next to it.

    Raises:
        UsageError: no format can, a file is in the way, or they cannot be written.
    """
    from cortex_dsl.interchange.formats import gather
    from cortex_dsl.report.findings.interchange_report import Written
    from engine.errors import InterchangeError

    try:
        gathered = gather(cases, formats, how)
    except InterchangeError as error:
        raise UsageError(f"{error.place}: {error.message}", error.cure) from None
    certificates = [] if esmini is None else with_certificates(gathered, cases, how, esmini)
    same = place_files(folder, gathered.files, force=force, flags=flags)
    opened = {name: kind.opened for name, kind in FORMATS.items()}
    if how.player == "carla":
        opened["xosc"] = PLAYED_BY_CARLA.replace("RATE", f"{1.0 / cases[0].recording.step:g}")
    return Written(cases, gathered, folder, same, None, {}, opened, certificates)


def with_certificates(
    gathered: "Gathered", cases: "Sequence[ExportCase]", how: "ExportOptions", library: Path
) -> "list[Certificate]":
    """Play each case, and put its certificate among its files."""
    from engine.interchange.esmini.fidelity import SUFFIX, certified

    certificates: list[Certificate] = []
    for case, names in zip(cases, gathered.names, strict=True):
        files = {name: gathered.files[name] for name in names if name.endswith((".xosc", ".xodr"))}
        if f"{case.recording.name}.xosc" not in files:
            continue
        certificates.append(certified(library, case, files, how))
        name = f"{case.recording.name}{SUFFIX}"
        gathered.files[name] = certificates[-1].text.encode()
        gathered.formats[name] = "xosc"
        names.append(name)
    return certificates
