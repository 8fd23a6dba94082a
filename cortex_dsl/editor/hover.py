"""Hover text of the word under the pointer, as Markdown."""

from dataclasses import dataclass

from pygments.token import Number

from cortex_dsl.editor.analysis import View, explained_unit
from cortex_dsl.editor.lexer import Token
from cortex_dsl.editor.place import place_of
from cortex_dsl.editor.symbols import Symbol
from cortex_dsl.semantics.names.attribute_docs import ATTRIBUTE_DOCS
from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, Builtin, Kind, Parameter
from cortex_dsl.semantics.names.properties import ENVIRONMENT, FLAGS, IGNORED, PROPERTIES, Domain
from cortex_dsl.semantics.quantities.units import UNITS, dimension_name, si_word
from cortex_dsl.source import Span
from cortex_dsl.syntax.words import KEYWORDS, Keyword, Role


@dataclass(frozen=True)
class Hover:
    span: Span
    text: str


def hover(view: View, offset: int) -> Hover | None:
    """Return the hover text for an offset; None without a known token."""
    index = view.index(offset)
    if index < 0 or view.tokens[index].is_text:
        return None
    token = view.tokens[index]
    text = _number(view, index) if token.kind in Number else _word(view, index, token)
    return Hover(token.span, text) if text else None


def _word(view: View, index: int, token: Token) -> str:
    before = view.tokens[index - 1].text if index else ""
    if token.is_unit:
        return unit_text(token.text)
    if token.is_keyword:
        return _keyword(view, index)
    if not token.is_name:
        return ""
    if before == ".":
        return _attribute(view, token)
    if before == "with":
        return property_text(token.text)
    return _argument(view, index) or _name(view, token)


def _argument(view: View, index: int) -> str:
    """The name of an argument of `environment`, which is no property of objects."""
    token, following = view.tokens[index], view.tokens[index + 1 : index + 2]
    place = place_of(view, token.end) if following and following[0].text == "=" else None
    if place is None or place.callee < 0 or place.left[place.callee].text != "environment":
        return ""
    spec = ENVIRONMENT.get(token.text)
    return joined(code(f"environment({spec.name}=…)"), domain_text(spec), spec.doc) if spec else ""


def _name(view: View, token: Token) -> str:
    symbol = view.known(token.start).get(token.text)
    here = view.value_text(view.observed_at(token.span))
    if symbol is not None:
        return symbol_text(view, symbol, here)
    if token.text in BUILTINS:
        return builtin_text(BUILTINS[token.text])
    if token.text in SPECIAL_NAMES:
        return joined(code(token.text), here, SPECIAL_NAMES[token.text])
    return property_text(token.text) if token.text in (*PROPERTIES, *FLAGS) else here


def symbol_text(view: View, symbol: Symbol, here: str = "") -> str:
    """Return the text of a definition: its form, its value, and its docstring."""
    value_text = view.value_text(view.values_of(symbol)) or here
    if not symbol.parameters and symbol.kind.value not in ("behavior", "monitor", "scenario", "class", "import"):
        value_text = (
            value_text
            if symbol.kind.value == "object" and value_text
            else ": ".join(filter(None, (symbol.kind.value, value_text)))
        )
    return joined(code(symbol.form or symbol.name), value_text, symbol.doc)


def builtin_text(builtin: Builtin) -> str:
    """Return signature, sentence, and the requirements on each argument."""
    arguments = [f"- `{p.name}`: {argument_text(p)}" for p in builtin.parameters if argument_text(p)]
    head = f"{builtin.kind.value} {builtin.signature}" if builtin.kind is not Kind.CONSTANT else builtin.name
    return joined(code(head), builtin.doc, "\n".join(arguments))


def argument_text(parameter: Parameter) -> str:
    """`a speed, 0 to 200 m/s, 10 m/s unless given`."""
    parts = []
    if parameter.dimension is not None:
        parts.append(dimension_name(parameter.dimension))
        parts.append(range_text(parameter.low, parameter.high, si_word(parameter.dimension)))
    if parameter.default is not None:
        parts.append(f"{parameter.default} unless given")
    return ", ".join(filter(None, parts))


def range_text(low: float, high: float, unit: str) -> str:
    ends = (low != float("-inf"), high != float("inf"))
    if ends == (True, True):
        return f"{low:g} to {high:.6g} {unit}".rstrip()
    return f"at least {low:g} {unit}".rstrip() if ends[0] else f"at most {high:.6g} {unit}".rstrip() if ends[1] else ""


def domain_text(domain: Domain) -> str:
    """`a length, at least 0 m`."""
    limits = range_text(domain.low, domain.high, si_word(domain.dimension))
    return ", ".join(filter(None, (dimension_name(domain.dimension), limits)))


def property_text(name: str) -> str:
    """A property of objects, as `with` sets it."""
    if name in PROPERTIES:
        spec = PROPERTIES[name]
        if spec.truth:
            return joined(code(f"with {name}"), "`True` or `False`", spec.doc)
        return joined(code(f"with {name}"), domain_text(spec), spec.doc)
    if name in IGNORED:
        return joined(code(f"with {name}"), f"Read and not used: {IGNORED[name]}.")
    return joined(code(f"with {name}"), FLAGS[name]) if name in FLAGS else ""


def _attribute(view: View, token: Token) -> str:
    value_text = view.value_text(view.observed_at(token.span))
    doc = attribute_doc(token.text)
    return joined(code(token.text), value_text, doc) if value_text or doc else ""


def attribute_doc(name: str) -> str:
    if name in ATTRIBUTE_DOCS:
        return ATTRIBUTE_DOCS[name]
    return PROPERTIES[name].doc if name in PROPERTIES else FLAGS.get(name, "")


def unit_text(word: str) -> str:
    """Return a unit's dimension and size."""
    unit = UNITS[word]
    others = ", ".join(f"`{u.word}`" for u in UNITS.values() if u.dimension == unit.dimension and u is not unit)
    return joined(code(f"1 {word}"), explained_unit(unit.dimension, unit.factor), f"also {others}" if others else "")


def _number(view: View, index: int) -> str:
    """A number with a unit, in SI."""
    token = view.tokens[index]
    unit = view.tokens[index + 1] if index + 1 < len(view.tokens) else None
    if unit is None or not unit.is_unit or UNITS[unit.text].factor == 1.0:
        return ""
    spec = UNITS[unit.text]
    value = float(token.text.replace("_", "")) * spec.factor
    return joined(code(f"{token.text} {unit.text}"), f"{value:.6g} {si_word(spec.dimension)}")


def _keyword(view: View, index: int) -> str:
    token = view.tokens[index]
    line = view.text.rfind("\n", 0, token.start) + 1
    first = not view.text[line : token.start].strip()
    roles = (Role.STATEMENT, Role.ACT, Role.CLAUSE) if first else (Role.OPERATOR, Role.SPECIFIER, Role.LINK)
    found = keywords_named(" ".join(token.text.split()))
    fitting = [k for k in found if k.role in roles] or found
    return keyword_text(fitting[0]) if fitting else ""


def keywords_named(phrase: str) -> list[Keyword]:
    """Rows of a phrase, else those that begin with it."""
    exact = [k for k in KEYWORDS if k.phrase == phrase]
    return exact or [k for k in KEYWORDS if k.words[0] == phrase]


def keyword_text(keyword: Keyword) -> str:
    return joined(code(keyword.form), keyword.doc)


def code(text: str) -> str:
    return f"```scn\n{text}\n```"


def joined(*parts: str) -> str:
    """Paragraphs, those that are empty left out."""
    return "\n\n".join(part for part in parts if part)


def parameters_of(view: View, name: str, offset: int) -> tuple[str, tuple[tuple[str, str], ...]] | None:
    """Return the form of the callable `name`, and its arguments with their texts; None if it cannot be called."""
    symbol = view.known(offset).get(name)
    if symbol is not None and symbol.parameters:
        return symbol.form, tuple((p.name, "") for p in symbol.parameters)
    builtin = BUILTINS.get(name)
    if builtin is not None and builtin.parameters:
        return builtin.signature, tuple((p.name, argument_text(p)) for p in builtin.parameters)
    return None
