"""Editing at a terminal: several lines, history, completion, colours, and a line that says how things stand."""

import os
import re
import shlex
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path

from prompt_toolkit import PromptSession
from prompt_toolkit.application.current import get_app
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.buffer import Buffer
from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document
from prompt_toolkit.filters import completion_is_selected, has_completions
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.key_binding import KeyBindings, KeyPressEvent
from prompt_toolkit.keys import Keys
from prompt_toolkit.lexers import DynamicLexer, Lexer, PygmentsLexer, SimpleLexer
from prompt_toolkit.output import ColorDepth
from prompt_toolkit.styles import Style, merge_styles
from prompt_toolkit.styles.pygments import pygments_token_to_classname

from cortex_dsl.console.user_files import is_folder
from cortex_dsl.editor.analysis import Analysis, View, analyse
from cortex_dsl.editor.completion import complete
from cortex_dsl.editor.fitting import Candidate
from cortex_dsl.editor.lexer import ScnLexer, word_before
from cortex_dsl.repl.chunks import MORE, PROMPT, is_command, is_whole, parted
from cortex_dsl.repl.colours import for_prompt
from cortex_dsl.repl.commands import COMMANDS
from cortex_dsl.repl.state import State
from cortex_dsl.report.findings.readable import counted, percent

# -- completions for the words after a command -------------------------------------------------------------------------


Offer = tuple[str, str]
"""A word, and its description."""


def of_command(state: State, analysis: Analysis, text: str, event: CompleteEvent) -> Iterator[Completion]:
    """Complete a line after its colon: the name of the command, or its present word; `analysis`: of the draft."""
    name, blank, rest = text.partition(" ")
    if not blank:
        yield from _named(name, ((row.name, row.summary) for row in COMMANDS.values()))
        return
    row = COMMANDS.get(name.removesuffix("!"))
    if row is None or not row.completes:
        return
    *before, word = rest.lstrip().split(" ", len(row.completes) - 1) if rest.strip() else [""]
    kind = row.completes[min(len(before), len(row.completes) - 1)]
    if kind in PATHS:
        yield from PathCompleter(expanduser=True, file_filter=PATHS[kind]).get_completions(Document(word), event)
    elif kind == "value":
        yield from _values(state, analysis, word)
    elif kind == "aim":
        yield from _aims(state, word)
    else:
        yield from _named(word.rpartition(",")[2] if kind == "format" else word, KINDS[kind](state))


def _named(begun: str, offers: Iterator[Offer]) -> Iterator[Completion]:
    for word, meta in offers:
        if word.lower().startswith(begun.lower()):
            yield Completion(word, -len(begun), display_meta=meta)


# -- an expression -----------------------------------------------------------------------------------------------------

ASKING = ("maximize ", "expect ")
"""Statements of numbers and of truths; the beginning of both can be plotted."""


def _values(state: State, analysis: Analysis, argument: str) -> Iterator[Completion]:
    """Yield continuations of the last expression."""
    part = parted(argument)[-1] + (" " if argument.endswith(" ") else "")
    word = word_before(part, len(part))
    found: dict[str, Candidate] = {}
    for asking in ASKING:
        text = f"{state.draft.text}{asking}{part}"
        for each in complete(View(state.name, text, analysis), len(text)):
            best = found.setdefault(each.label, each)
            found[each.label] = min(best, each, key=lambda c: c.rank)
    for each in sorted(found.values(), key=lambda c: (c.rank, c.label.lower())):
        if each.label.lower().startswith(word.lower()):
            yield Completion(each.label, -len(word), display_meta=each.detail or each.kind)


# -- objectives of a search --------------------------------------------------------------------------------------------


def _aims(state: State, argument: str) -> Iterator[Completion]:
    """Yield the flag, and after it a name of an objective."""
    before, _, word = argument.rpartition(" ")
    if not before.endswith("--objective"):
        yield from _named(word, iter([("--objective", "objective of the search, instead of the risk")]))
        return
    from engine.search.objectives import BUILT_IN, of_file

    compiled = state.checked.compiled
    rows = (*BUILT_IN, *(() if compiled is None else of_file(compiled.program)))
    yield from _named(word, ((shlex.quote(row.name), row.sentence) for row in rows))


# -- words of a kind ---------------------------------------------------------------------------------------------------


def _params(state: State) -> Iterator[Offer]:
    program = state.checked.weighable
    yield from ((name, "param") for name in (() if program is None else program.space.names))


def _codes(_state: State) -> Iterator[Offer]:
    from cortex_dsl.codes import entries

    yield from ((entry.code, entry.title) for entry in entries())


def _commands(_state: State) -> Iterator[Offer]:
    yield from ((row.name, row.summary) for row in COMMANDS.values())


def _names(state: State) -> Iterator[Offer]:
    from cortex_dsl.repl.commands_info import known

    yield from ((name, "") for name in dict.fromkeys(known(state)))


def _entries(state: State) -> Iterator[Offer]:
    for number, entry in enumerate(state.draft.entries, start=1):
        yield str(number), entry.strip().split("\n")[0]


def _cases(state: State) -> Iterator[Offer]:
    for case in () if state.found is None else state.found.campaign.worst:
        yield str(case.rank), f"risk {case.score}"


def _formats(_state: State) -> Iterator[Offer]:
    from cortex_dsl.interchange.formats import FORMATS

    yield from ((name, row.summary) for name, row in FORMATS.items())


def _paces(_state: State) -> Iterator[Offer]:
    yield from ((pace, "as fast as it happens") for pace in ("0.25x", "0.5x", "1x", "2x", "4x"))


KINDS: Mapping[str, Callable[[State], Iterator[Offer]]] = {
    "param": _params,
    "code": _codes,
    "command": _commands,
    "name": _names,
    "entry": _entries,
    "case": _cases,
    "format": _formats,
    "pace": _paces,
}


def _is_scenario(name: str) -> bool:
    path = Path(name)
    return path.suffix in (".scn", ".scenic") or is_folder(path)


PATHS: Mapping[str, Callable[[str], bool]] = {"file": _is_scenario, "path": lambda _name: True}


# -- input of earlier sessions, in the user's state folder; nothing fails without it -----------------------------------


class TolerantHistory(FileHistory):
    """A history file that may vanish or become full while the session lasts."""

    def load_history_strings(self) -> Iterable[str]:
        try:
            return list(super().load_history_strings())
        except OSError:
            return []

    def store_string(self, string: str) -> None:
        """Keep an entry; bytes that were no text become `?`: older versions of the library cannot write them."""
        with suppress(OSError):
            super().store_string(string.encode("utf-8", "replace").decode("utf-8"))


def past_entries() -> History:
    """Return the history file of the user, or one that lasts as long as the session."""
    with suppress(OSError, RuntimeError):
        folder = _state_folder()
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        file = folder / "history"
        file.touch(mode=0o600)
        if os.access(file, os.R_OK | os.W_OK):
            return TolerantHistory(str(file))
    return InMemoryHistory()


def _state_folder() -> Path:
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "cortexc"


# -- completion on Tab: the language's completion over the whole draft, and the words of commands ----------------------


class DraftCompleter(Completer):
    """Completes with the present state."""

    def __init__(self, state: State) -> None:
        self._state = state
        self._analysed: tuple[str, Analysis] | None = None

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        text = document.text_before_cursor
        if is_command(text) and text.lstrip().startswith(":"):
            analysis = self._analysis(self._state.draft.text)
            return of_command(self._state, analysis, text.lstrip()[1:], complete_event)
        return self._of_language(document)

    def _of_language(self, document: Document) -> Iterator[Completion]:
        draft = self._state.draft.text
        view = View(self._state.name, draft + document.text, self._analysis(draft))
        offset = len(draft) + document.cursor_position
        word = word_before(document.text, document.cursor_position)
        fitting = [c for c in complete(view, offset) if c.label.lower().startswith(word.lower())]
        for found in sorted(fitting, key=lambda c: (c.rank, c.label.lower())):
            yield Completion(found.label, -len(word), display_meta=found.detail or found.kind)

    def _analysis(self, text: str) -> Analysis:
        if self._analysed is None or self._analysed[0] != text:
            self._analysed = text, analyse(self._state.name, text)
        return self._analysed[1]


# -- the prompt --------------------------------------------------------------------------------------------------------

NO_TEXT = re.compile("[\ud800-\udfff]")
"""Characters that a terminal makes of bytes that are not UTF-8."""
INDENT = "    "
REFRESH = 0.5
"""Seconds after which the line at the bottom is looked at again: kernels may have become ready."""


class EditedInput:
    """Chunks that are edited before they are entered."""

    def __init__(self, state: State) -> None:
        self._state = state
        plain = state.terminal.out.color_system is None
        self._session: PromptSession[str] = PromptSession(
            multiline=True,
            history=past_entries(),
            completer=DraftCompleter(state),
            complete_while_typing=False,
            auto_suggest=AutoSuggestFromHistory(),
            lexer=DynamicLexer(self._lexer),
            style=merge_styles([_style()]),
            color_depth=ColorDepth.DEPTH_1_BIT if plain else ColorDepth.DEPTH_4_BIT,
            key_bindings=_keys(),
            prompt_continuation=lambda *_: [("class:prompt", MORE)],
            bottom_toolbar=self._toolbar,
            refresh_interval=REFRESH,
            include_default_pygments_style=False,
            reserve_space_for_menu=6,
            enable_suspend=True,
        )
        self._language = PygmentsLexer(ScnLexer, sync_from_start=True)
        self._order = SimpleLexer("class:order")

    def read(self) -> str | None:
        proposal, self._state.proposal = self._state.proposal, ""
        try:
            text = self._session.prompt([("class:prompt", PROMPT)], default=proposal)
        except EOFError:
            return None
        return NO_TEXT.sub("\ufffd", text).strip("\n").rstrip()

    def _lexer(self) -> Lexer:
        return self._order if is_command(get_app().current_buffer.text) else self._language

    def _toolbar(self) -> StyleAndTextTuples:
        try:
            return [("class:state", f" {state_of(self._state)} ")]
        except Exception:  # the command that needs the failed part shows it; a line at the bottom ends no session
            return []


def state_of(state: State) -> str:
    """Return the state of the session in one line."""
    checked, program = state.checked, state.checked.weighable
    parts = [f"{state.name}{' *' if state.unsaved else ''}"]
    if state.editing is not None:
        parts.insert(0, f"editing entry {state.editing + 1}")
    if checked.errors:
        parts.append(counted(len(checked.errors), "error"))
    elif checked.missing:
        parts.append("still to come: ego")
    if program is not None:
        parts += [counted(len(program.space), "param")]
        parts += [] if checked.missing else [counted(len(program.actors), "actor")]
        parts.append(_accepted(state))
    if state.overrides:
        parts.append(f"{len(state.overrides)} held")
    return " · ".join(parts)


def _accepted(state: State) -> str:
    share = state.acceptance
    if share is None:
        return "compiling kernels …" if state.kernels.missing else "loading kernels …"
    return f"{percent(share, 2 if 0 < share < 0.1 else 1)} accepted"


def _style() -> Style:
    rules = [(pygments_token_to_classname(kind), style) for kind, style in for_prompt()]
    return Style(
        [
            *rules,
            ("prompt", "ansiblue bold"),
            ("order", "ansiyellow"),
            ("bottom-toolbar", "noreverse"),
            ("state", "ansibrightblack noreverse"),
            ("auto-suggestion", "ansibrightblack"),
        ]
    )


def _keys() -> KeyBindings:
    keys = KeyBindings()
    indented: list[str] = []  # the text that ends with an indentation of ours, until more is typed

    @keys.add("enter", filter=has_completions & completion_is_selected)
    def _(event: KeyPressEvent) -> None:
        event.current_buffer.complete_state = None

    @keys.add("enter", filter=~(has_completions & completion_is_selected))
    def _(event: KeyPressEvent) -> None:
        buffer = event.current_buffer
        if "\n" not in buffer.document.text_after_cursor.rstrip() and is_whole(buffer.text):
            buffer.validate_and_handle()
        else:
            buffer.insert_text("\n" + _indent(buffer.document.current_line_before_cursor))
            indented[:] = [buffer.text]

    @keys.add(" ")
    def _(event: KeyPressEvent) -> None:
        _replace_indentation(event.current_buffer, indented)
        event.current_buffer.insert_text(" ")

    @keys.add(Keys.BracketedPaste)
    def _(event: KeyPressEvent) -> None:
        pasted = event.data.replace("\r\n", "\n").replace("\r", "\n")
        if pasted.startswith((" ", "\t")):
            _replace_indentation(event.current_buffer, indented)
        event.current_buffer.insert_text(pasted)

    @keys.add("tab", filter=~has_completions)
    def _(event: KeyPressEvent) -> None:
        _complete(event.current_buffer)

    @keys.add("escape", "enter")
    def _(event: KeyPressEvent) -> None:
        event.current_buffer.validate_and_handle()

    return keys


def _replace_indentation(buffer: Buffer, indented: list[str]) -> None:
    """Take back the indentation that Enter wrote before a line that begins with blanks of its own."""
    if indented == [buffer.text] and not buffer.document.text_after_cursor:
        buffer.delete_before_cursor(len(buffer.document.current_line_before_cursor))
    indented.clear()


def _complete(buffer: Buffer) -> None:
    """Insert an indentation at the beginning of a line, or a unique completion; else show a menu."""
    line = buffer.document.current_line_before_cursor
    if not line.strip() and "\n" in buffer.text:
        buffer.insert_text(INDENT)
        return
    found = list(buffer.completer.get_completions(buffer.document, CompleteEvent(completion_requested=True)))
    if len(found) == 1:
        buffer.apply_completion(found[0])
    elif found:
        buffer.start_completion(insert_common_part=True)


def _indent(line: str) -> str:
    """Return the indentation of the line after this one."""
    own = line[: len(line) - len(line.lstrip())]
    opens = line.rstrip().endswith((":", "(", "[", ",")) and not own
    return own + INDENT if opens or line.rstrip().endswith(":") else own
