"""The TextMate grammar that editors load, made from the tables: `python -m cortex_dsl.editor.textmate` writes it.

In a clone it goes into `editors/`; an installed cortexc has no such folder and prints it.

Its rules have the order and the expressions of the lexer's; a test compares the colours of both.
"""

import sys
from pathlib import Path
from typing import Any

from cortex_dsl.editor import lexer
from cortex_dsl.editor.lexer import BLANK, NAME
from cortex_dsl.semantics.names.builtins import Kind
from engine.strict_json import json_text

PATH = Path(__file__).parents[2] / "editors" / "cortex.tmLanguage.json"
SCOPE = "source.scn"
START = rf"(?:^|[:;]){BLANK}*"
"""Beginning of a statement: the beginning of a line, or the text after the colon of a block or a semicolon."""

Rule = dict[str, Any]


def _match(pattern: str, *captures: str, name: str = "") -> Rule:
    """A rule; `captures` are the scopes of its groups, "" for one without."""
    rule: Rule = {"match": pattern}
    if name:
        rule["name"] = f"{name}.scn"
    if captures:
        rule["captures"] = {str(i): {"name": f"{scope}.scn"} for i, scope in enumerate(captures, 1) if scope}
    return rule


def _quoted(before: str, quotes: str, name: str) -> Rule:
    """Text that may go on over several lines."""
    rule: Rule = {"name": f"{name}.scn", "begin": before + quotes, "end": quotes}
    return rule | {"patterns": [_match(r"\\[\s\S]", name="constant.character.escape")]}


def _include(*names: str) -> list[Rule]:
    return [{"include": f"#{name}"} for name in names]


def _statements() -> list[Rule]:
    definition = ("storage.type", "", "entity.name.function")
    return [
        _quoted(rf"^{BLANK}*", '"""', "string.quoted.docstring"),
        _quoted(rf"^{BLANK}*", "'''", "string.quoted.docstring"),
        _match(rf"{START}(param)({BLANK}+)({NAME})(?={BLANK}*=)", "storage.type", "", "variable.other.assignment"),
        _match(rf"{START}(class)({BLANK}+)({NAME})", "storage.type", "", "entity.name.type.class"),
        _match(START + lexer.DEFINITION, *definition),
        _match(rf"{START}({lexer.STATEMENT})", "keyword.control"),
        _match(rf"{START}(?!{lexer.LINK})({lexer.ASSIGNED})", "variable.other.assignment"),
        _match(rf"^{BLANK}*(?!{lexer.LINK})({NAME})(?={BLANK}*:)", "variable.other.property"),
    ]


def _strings() -> list[Rule]:
    return [
        _quoted(r"(?:\b[fF])?", '"""', "string.quoted.triple"),
        _quoted(r"(?:\b[fF])?", "'''", "string.quoted.triple"),
        _match(r'(?:\b[fF])?"(?:[^"\\\n]|\\[^\n])*"?', name="string.quoted.double"),
        _match(r"(?:\b[fF])?'(?:[^'\\\n]|\\[^\n])*'?", name="string.quoted.single"),
    ]


def _numbers() -> list[Rule]:
    number, unit = "constant.numeric", "keyword.other.unit"
    return [
        _match(rf"\b({lexer.NUMBER}){BLANK}*({lexer.UNIT})", number, unit),
        _match(rf"(?<=\)){BLANK}*({lexer.UNIT})", unit),
        _match(rf"\b{lexer.NUMBER}|(?<![\w.])\.\d[\d_]*(?:[eE][-+]?\d+)?", name=number),
    ]


def _words() -> list[Rule]:
    keyword = "keyword.control"
    return [
        _match(r"\b(lambda)\b([^:\n)\]}]*)", keyword, "variable.parameter.lambda"),
        _match(rf"\b(new){BLANK}+({NAME})", keyword, "entity.name.type.class"),
        _match(rf"\b(with){BLANK}+({NAME})", keyword, "variable.other.property"),
        _match(rf"\b(as){BLANK}+({NAME})", keyword, "entity.name.label"),
        _match(rf"(\.){BLANK}*({NAME})", "keyword.operator", "variable.other.property"),
        _match(rf"\b{lexer.CONSTANT}", name="constant.language"),
        _match(r"\bdeg\b", name="keyword.other.unit"),
        _match(rf"\b{lexer.INSTANT}", name=keyword),
        _match(rf"\b{lexer.OPERATOR}", name="keyword.operator.word"),
        _match(rf"\b{lexer.SPECIFIER}", name=keyword),
        _match(rf"\b{lexer.LINK}", name=keyword),
    ]


def _names() -> list[Rule]:
    return [
        _match(rf"\b{lexer.NAMED_ARGUMENT}", name="variable.parameter"),
        _match(rf"\b{lexer.SPECIAL}", name="variable.language"),
        _match(rf"\b{lexer.builtins(Kind.FUNCTION, Kind.DISTRIBUTION)}", name="support.function.builtin"),
        _match(rf"\b{lexer.builtins(Kind.ACTION, Kind.BEHAVIOUR)}", name="entity.name.function.library"),
        _match(rf"\b{lexer.builtins(Kind.CLASS)}", name="entity.name.type.class"),
        _match(rf"\b{lexer.builtins(Kind.CONSTANT)}", name="variable.language"),
        _match(NAME),
        _match(lexer.SIGN, name="keyword.operator"),
    ]


def build() -> Rule:
    """The grammar as JSON has it."""
    return {
        "$comment": "Made by `python -m cortex_dsl.editor.textmate` from the tables of the language.",
        "name": "cortexc scenario",
        "scopeName": SCOPE,
        "fileTypes": ["scn"],
        "patterns": _include("comments", "statements", "strings", "numbers", "words", "names"),
        "repository": {
            "comments": {"patterns": [_match(r"#[^\n]*", name="comment.line.number-sign")]},
            "statements": {"patterns": _statements()},
            "strings": {"patterns": _strings()},
            "numbers": {"patterns": _numbers()},
            "words": {"patterns": _words()},
            "names": {"patterns": _names()},
        },
    }


def text() -> str:
    """The file."""
    return json_text(build(), indent=2) + "\n"


if __name__ == "__main__":
    if PATH.parent.is_dir():
        PATH.write_text(text(), encoding="utf-8")
        sys.stdout.write(f"{PATH.name}: written\n")
    else:
        sys.stdout.write(text())
