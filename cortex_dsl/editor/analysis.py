"""A text, compiled for an editor: its errors, and all facts that were found before the errors.

Pure functions over text. The server holds one `View` for each open file and calls the other modules of this folder.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from cortex_dsl import ir
from cortex_dsl.diagnostics import CompileError, Diagnostic, Severity
from cortex_dsl.editor.lexer import Token, index_at, tokens_of
from cortex_dsl.editor.symbols import Symbol, SymbolKind, symbols_of, visible
from cortex_dsl.files import DISK, Files
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.model.context import ObservedValue, ObservedValues, ValueRecorder
from cortex_dsl.semantics.model.values import Actor, Quantity, Truth, Value
from cortex_dsl.semantics.model.wording import kind_name, option_name, param_units
from cortex_dsl.semantics.names.linking import ImportedFile, link
from cortex_dsl.semantics.quantities.units import UNITS, Unit, dimension_name, si_formula, si_word
from cortex_dsl.source import Source, Span
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.syntax.reading import decode
from engine.vocabulary import GeneKind


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

    def value_text(self, values: ObservedValues) -> str:
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


# -- values in words ---------------------------------------------------------------------------------------------------


MOST_OPTIONS = 6
"""Options that a hover text names."""


def ending_at(seen: Mapping[Span, ObservedValues], span: Span) -> ObservedValues:
    """Values of the narrowest expression that ends where a span ends and begins no later: `a.b` for the span of `b`."""
    fitting = [each for each in seen if each.end == span.end and each.start <= span.start]
    return seen[max(fitting, key=lambda each: each.start)] if fitting else ()


def described(observed: ObservedValues, *, partly: bool = False) -> str:
    """Return a description of values in one line: kind, range or options; empty without values.

    `partly`: there may be more values than those seen.
    """
    if not observed:
        return ""
    kinds = list(dict.fromkeys(_kind(each) for each in observed))
    if len(kinds) > 1:
        return ", or ".join(kinds[:3])
    value = observed[0].value
    details = _numbers(observed) if isinstance(value, Quantity) else _options(observed, partly)
    return ", ".join(filter(None, (kinds[0], details)))


def _kind(observed: ObservedValue) -> str:
    value = observed.value
    if isinstance(value, Quantity) and value.dimension is None and isinstance(value.expr, ir.Literal):
        return "a number"
    if isinstance(value, tuple) and value:
        alike = len({kind_name(item) for item in value}) == 1
        return f"a list of {len(value)}" + (f": {kind_name(value[0])} each" if alike else "")
    return kind_name(value)


def _options(observed: ObservedValues, partly: bool) -> str:
    """Names of things, where they have any that the kind does not say."""
    names = list(dict.fromkeys(option_name(each.value) for each in observed if _is_thing(each.value)))
    if not names:
        return ""
    shown = ", ".join(f"`{name}`" for name in names[:MOST_OPTIONS]) + (", …" if len(names) > MOST_OPTIONS else "")
    if len(names) > 1:
        return f"one of {shown}"
    return f"such as {shown}" if partly and not isinstance(observed[0].value, Actor | Truth) else shown


def _is_thing(value: Value) -> bool:
    if isinstance(value, Truth):
        return isinstance(value.expr, ir.Literal)
    return option_name(value) != kind_name(value) and not isinstance(value, tuple)


def _numbers(observed: ObservedValues) -> str:
    """The numbers between which the values lie, where that is known."""
    first = observed[0]
    assert isinstance(first.value, Quantity)
    if isinstance(first.value.expr, ir.Gene):
        gene = first.evaluator.file.genes.infos[first.value.expr.index]
        return gene_range(gene, si_word(first.value.dimension))
    ends = [s.evaluator.interval(s.value.expr) for s in observed if isinstance(s.value, Quantity)]
    low, high = min(low for low, _ in ends), max(high for _, high in ends)
    unit = si_word(first.value.dimension) or si_formula(first.value.dimension or ir.PURE)
    text = _between(low, high, "" if unit == "1" else unit)
    own = _own_unit(first)
    return f"{text} ({_between(low / own.factor, high / own.factor, own.word)})" if text and own else text


def _own_unit(observed: ObservedValue) -> Unit | None:
    """The unit in which a param behind a number is written, where it is another than that of SI."""
    assert isinstance(observed.value, Quantity)
    words = param_units(observed.value.expr, observed.evaluator.file.genes.infos)
    units = (UNITS[word] for word in words if word in UNITS)
    return next((u for u in units if u.dimension == observed.value.dimension and u.factor != 1.0), None)


def _between(low: float, high: float, unit: str) -> str:
    if math.isinf(low) and math.isinf(high):
        return ""
    if low == high:
        return f"{low:.6g} {unit}".rstrip()
    if math.isinf(low) or math.isinf(high):
        return f"{'at most' if math.isinf(low) else 'at least'} {high if math.isinf(low) else low:.6g} {unit}".rstrip()
    return f"{low:.6g} to {high:.6g} {unit}".rstrip()


def gene_range(gene: ir.GeneInfo, unit: str) -> str:
    """The range of a param, in its own unit and in SI."""
    if gene.kind == GeneKind.INDEX:
        return "one of " + ", ".join(f"`{option}`" for option in gene.options[:MOST_OPTIONS])
    own = _between(gene.low, gene.high, gene.unit)
    if gene.scale == 1.0 or not gene.unit:
        return own
    return f"{own} ({gene.low * gene.scale:.4g} to {gene.high * gene.scale:.4g} {unit})"


def explained_unit(dimension: ir.Dimension, factor: float) -> str:
    """Return a description of a unit: `a speed, 0.277778 m/s`."""
    return dimension_name(dimension) + (f", {factor:.6g} {si_word(dimension)}" if factor != 1.0 else "")
