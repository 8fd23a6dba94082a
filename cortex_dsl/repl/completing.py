"""What Tab offers: the language's completion over the whole draft, and the arguments of commands."""

from collections.abc import Iterable, Iterator
from pathlib import Path

from prompt_toolkit.completion import CompleteEvent, Completer, Completion, PathCompleter
from prompt_toolkit.document import Document

from cortex_dsl.cli.files import is_folder
from cortex_dsl.editor.analysis import Analysis, View, analyse
from cortex_dsl.editor.completion import complete
from cortex_dsl.editor.tokens import word_before
from cortex_dsl.repl.commands import COMMANDS
from cortex_dsl.repl.desk import Desk
from cortex_dsl.repl.reading import is_command


class DeskCompleter(Completer):
    """Completes against what the desk holds now."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._paths = PathCompleter(expanduser=True, file_filter=_is_scenario)
        self._analysed: tuple[str, Analysis] | None = None

    def get_completions(self, document: Document, complete_event: CompleteEvent) -> Iterable[Completion]:
        text = document.text_before_cursor
        if is_command(text) and text.lstrip().startswith(":"):
            return self._of_command(text.lstrip()[1:], complete_event)
        return self._of_language(document)

    # -- the language ------------------------------------------------------------------------------------------------

    def _of_language(self, document: Document) -> Iterator[Completion]:
        draft = self._desk.draft.text
        view = View(self._desk.name, draft + document.text, self._analysis(draft))
        offset = len(draft) + document.cursor_position
        word = word_before(document.text, document.cursor_position)
        fitting = [c for c in complete(view, offset) if c.label.lower().startswith(word.lower())]
        for found in sorted(fitting, key=lambda c: (c.rank, c.label.lower())):
            yield Completion(found.label, -len(word), display_meta=found.detail or found.kind)

    def _analysis(self, text: str) -> Analysis:
        if self._analysed is None or self._analysed[0] != text:
            self._analysed = text, analyse(self._desk.name, text)
        return self._analysed[1]

    # -- commands ----------------------------------------------------------------------------------------------------

    def _of_command(self, text: str, event: CompleteEvent) -> Iterator[Completion]:
        name, blank, argument = text.partition(" ")
        if not blank:
            for row in COMMANDS.values():
                if row.name.startswith(name):
                    yield Completion(row.name, -len(name), display_meta=row.summary)
            return
        row = COMMANDS.get(name.removesuffix("!"))
        argument = argument.lstrip()
        if row is not None and row.completes == "file":
            yield from self._paths.get_completions(Document(argument), event)
        elif row is not None:
            for word, meta in self._arguments(row.completes):
                if word.lower().startswith(argument.lower()):
                    yield Completion(word, -len(argument), display_meta=meta)

    def _arguments(self, kind: str) -> Iterator[tuple[str, str]]:
        if kind == "param":
            program = self._desk.checked.weighable
            names = () if program is None else program.space.names
            yield from ((name, "param") for name in names)
        elif kind == "code":
            from cortex_dsl.api.codes import entries

            yield from ((entry.code, entry.title) for entry in entries())
        elif kind == "command":
            yield from ((row.name, row.summary) for row in COMMANDS.values())
        elif kind == "name":
            from cortex_dsl.repl.telling import known

            yield from ((name, "") for name in dict.fromkeys(known(self._desk)))


def _is_scenario(name: str) -> bool:
    path = Path(name)
    return path.suffix in (".scn", ".scenic") or is_folder(path)
