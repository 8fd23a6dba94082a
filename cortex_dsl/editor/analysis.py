"""A text, compiled for an editor: its errors, and all facts that were found before the errors.

Pure functions over text. The server holds one `View` for each open file and calls the other modules of this folder.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.editor.facts import described, ending_at
from cortex_dsl.editor.lexer import Token, index_at, tokens_of
from cortex_dsl.editor.symbols import Symbol, SymbolKind, symbols_of, visible
from cortex_dsl.files import DISK, Files
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.model.context import ObservedValue, ObservedValues, ValueRecorder
from cortex_dsl.semantics.names.linking import ImportedFile, link
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.reading import decode


@dataclass(frozen=True)
class Analysis:
    """Result of the compiler for one text."""

    source: Source
    diagnostics: tuple[Diagnostic, ...] = ()
    symbols: tuple[Symbol, ...] = ()
    seen: Mapping[Span, ObservedValues] = field(default_factory=dict, repr=False)
    module: nodes.Module | None = None
    """None where the text has no syntax tree."""
    imports: Mapping[Span, ImportedFile] = field(default_factory=dict, repr=False)
    """The file behind each import statement."""


def analyse(name: str, text: str, superseded: Callable[[], bool] = lambda: False, files: Files = DISK) -> Analysis:
    """Compile a text and return the facts; `name` is its path, next to which `files` looks for imports.

    Raises:
        Superseded: `superseded` returned True meanwhile.
    """
    try:
        source = decode(name, text.encode("utf-8", errors="replace"))
        module = parse(source)
    except CompileError as error:
        return Analysis(error.source, error.diagnostics)
    witness = ValueRecorder(superseded)
    result = Analysis(source, (), symbols_of(module, source), witness.seen, module)
    try:
        linked = link(module, source, files)
        result = replace(result, source=linked.source, imports=linked.files)
        _, diagnostics = elaborate(module, linked.source, imports=linked.files, observe=witness)
    except CompileError as error:
        return replace(result, source=error.source, diagnostics=error.diagnostics)
    return replace(result, diagnostics=diagnostics)


@dataclass(frozen=True)
class View:
    """The present text of the editor, and the last analysis with a tree: of this text, or of a slightly older one."""

    name: str
    text: str
    analysis: Analysis
    files: Files = DISK
    """Source of the imported files."""

    @cached_property
    def tokens(self) -> tuple[Token, ...]:
        return tokens_of(self.text)

    @cached_property
    def fresh(self) -> bool:
        """Return whether the places of the analysis are those of the text."""
        return self.analysis.source.text == self.text

    def index(self, offset: int) -> int:
        return index_at(self.tokens, offset)

    def known(self, offset: int) -> Mapping[str, Symbol]:
        """Names known at an offset; while the text is ahead of its tree, all that the tree knows."""
        symbols = self.analysis.symbols
        if self.fresh:
            return visible(symbols, offset)
        return {**{symbol.name: symbol for symbol in symbols}, **visible(symbols, min(offset, self.tree_end))}

    @cached_property
    def tree_end(self) -> int:
        return len(self.analysis.source.text)

    def worth(self, values: ObservedValues) -> str:
        """Return a description of values; with errors in the file, some values may be missing."""
        partly = any(diagnostic.severity is Severity.ERROR for diagnostic in self.analysis.diagnostics)
        return described(values, partly=partly)

    def observed_at(self, span: Span) -> ObservedValues:
        """Values of the expression that ends like `span`, if it has been there when the text was last compiled."""
        return ending_at(self.analysis.seen, span) if self.fresh else ()

    def values_of(self, symbol: Symbol) -> ObservedValues:
        """Values that a definition has had: where it was evaluated, or else where it was used."""
        seen = self.analysis.seen
        if symbol.value is not None and (values := seen.get(symbol.value.span, ())):
            return values
        whole, scope = self.analysis.source.whole, symbol.scope
        uses = (s for s in seen if scope.start <= s.start < scope.end and whole[s.start : s.end] == symbol.name)
        values = next((seen[span] for span in uses), ())
        return self._as_param(symbol.name) if symbol.kind is SymbolKind.PARAM and not values else values

    def _as_param(self, name: str) -> ObservedValues:
        """Return the value of a param that no expression uses."""
        evaluator = next((each[0].evaluator for each in self.analysis.seen.values()), None)
        if evaluator is None or name not in evaluator.run.params:
            return ()
        return [ObservedValue(evaluator, evaluator.run.params[name])]
