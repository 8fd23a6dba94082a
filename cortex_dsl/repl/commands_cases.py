"""Commands on the cases of the last search: shown, played in the terminal, written to files."""

import shlex
from argparse import ArgumentTypeError
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from cortex_dsl.console.cases import PICTURES, known_formats, pace, picture, play_case, write_cases
from cortex_dsl.console.kernels import SEARCH
from cortex_dsl.console.terminal import UsageError
from cortex_dsl.console.user_files import OverwriteFlags, is_folder, place_files, user_path
from cortex_dsl.interchange.formats import FORMATS
from cortex_dsl.repl.state import LastSearch, State, whole_number
from cortex_dsl.report.terminal.theme import heading
from cortex_dsl.spelling import nearest

if TYPE_CHECKING:
    from cortex_dsl.report.findings.case_replay import CaseReplay
    from engine.search.ranking import Case

IN_SESSION = OverwriteFlags(":export N", ":export!")


def do_worst(state: State, _argument: str) -> None:
    """Show the worst cases; the reference driver drives them once, on the first call."""
    found = _last(state)
    _wait_for(state, found)
    from cortex_dsl.report.findings.cases_found import cases_found
    from cortex_dsl.report.terminal.render import rendered
    from cortex_dsl.report.views.search import worst_cases_table

    if found.known is None:
        found.known = cases_found(found.scenario, found.campaign)
    note = found.settings if found.draft == state.draft else f"{found.settings}; the scenario was changed since"
    (table,) = worst_cases_table(found.scenario.program, found.campaign, found.known, note=note)
    state.terminal.out.print(rendered(table, state.terminal.out.width, depth=1))


def do_watch(state: State, argument: str) -> None:
    """A case again, as `cortexc replay` plays it."""
    number, _, speed = argument.partition(" ")
    case = _case(state, number or "1")
    try:
        times = pace(speed.strip()) if speed.strip() else 1.0
    except ArgumentTypeError as error:
        raise UsageError(f"the pace {error}", "as in `:watch 2 0.5x`") from None
    state.terminal.out.print(heading(f"case {case.rank} of {len(_last(state).campaign.worst)}", f"risk {case.score}"))
    play_case(_replayed(state, case), times, state.terminal)


def _replayed(state: State, case: "Case") -> "CaseReplay":
    _wait_for(state, _last(state))
    from cortex_dsl.report.findings.case_replay import replay_case

    scenario = _last(state).scenario
    remark = f"case {case.rank} of a search in {scenario.compiled.source.name}: risk {case.score}"
    return replay_case(scenario, scenario.scene(case), remark=remark, name=f"{case.rank:02d}.scn")


def _last(state: State) -> LastSearch:
    """The last search, which has found something.

    Raises:
        UsageError: there is none.
    """
    if state.found is None:
        raise UsageError("nothing has been searched yet", "`:ga` searches, `:random` too")
    if not state.found.campaign.worst:
        raise UsageError("the last search has no case: none of its simulations was valid", "`:sample` says why")
    return state.found


def _wait_for(state: State, found: LastSearch) -> None:
    state.kernels.wait(state.terminal, SEARCH, found.scenario.program, found.scenario.config)


def _case(state: State, number: str) -> "Case":
    worst = _last(state).campaign.worst
    return worst[whole_number(number, 1, "the number of a case", len(worst)) - 1]


# -- files -------------------------------------------------------------------------------------------------------------


def do_export(state: State, argument: str) -> None:
    """A case as files; the suffix of a single file says in which format."""
    loud = argument.startswith("!")
    try:
        words = shlex.split(argument.removeprefix("!"))
    except ValueError:
        raise UsageError("a quotation mark is not closed") from None
    if len(words) < 2:
        what = "export which case, and where to?" if not words else "export it where to?"
        raise UsageError(what, "as in `:export 1 case.scn`, or `:export 1 cases xosc,csv`")
    case, path = _case(state, words[0]), user_path(words[1])
    named = known_formats(word for each in words[2:] for word in each.split(",") if word)
    if path.suffix.lower() in PICTURES and not named and not is_folder(path):
        _write_picture(state, case, path, force=loud)
        return
    format_of_name = None if is_folder(path) else _format_of(path)
    if format_of_name is None and not named and path.suffix and not is_folder(path):
        raise _unknown_suffix(path)
    if format_of_name is None:
        _write(state, case, "", path, named or ("scn",), force=loud)
    else:
        suffix, of_name = format_of_name
        stem = path.name[: -len(suffix)]
        _write(state, case, stem, path.parent, (of_name, *(n for n in named if n != of_name)), force=loud)


def _format_of(path: Path) -> tuple[str, str] | None:
    """The suffix that a format's first file has, and the format; None: the name says nothing of it."""
    known = ((entry.suffixes[0], name) for name, entry in FORMATS.items())
    return next(((s, n) for s, n in known if path.name.lower().endswith(s) and len(path.name) > len(s)), None)


def _unknown_suffix(path: Path) -> UsageError:
    suffixes = [*(entry.suffixes[0] for entry in FORMATS.values()), *PICTURES]
    near = nearest(path.suffix.lower(), suffixes)
    cure = f"did you mean `{near}`?" if near else f"there are {', '.join(suffixes)}"
    return UsageError(f"no case is written as `{path.suffix}`", cure)


def _write(state: State, case: "Case", stem: str, folder: Path, formats: Sequence[str], *, force: bool) -> None:
    _wait_for(state, _last(state))
    from cortex_dsl.interchange.cases import case_of_search
    from cortex_dsl.report.terminal.export_view import export_view
    from engine.interchange.contract import ExportOptions

    known_formats(formats)
    how = ExportOptions("1.2", "trajectory")
    written = write_cases(
        [case_of_search(_last(state).scenario, case, stem)], formats, folder, how, force=force, flags=IN_SESSION
    )
    state.terminal.out.print(export_view(written, how))
    for error in written.gathered.refused.values():
        state.mistakes += 1
        state.terminal.complain(f"{error.place}: {error.message}", error.cure)


def _write_picture(state: State, case: "Case", path: Path, *, force: bool) -> None:
    content = picture(_replayed(state, case), path, case=case)
    data = content if isinstance(content, bytes) else content.encode("utf-8")
    place_files(path.parent, {path.name: data}, force=force, flags=IN_SESSION)
    state.terminal.out.print(f"wrote {path}", style="quiet", soft_wrap=True)
