"""The TextMate grammar is what its command writes, and colours as the lexer does.

It is read by a small reader: rules in order, the earliest match wins, blocks from `begin` to `end`, the expressions run
by Oniguruma, as editors do.
"""

import json
from functools import cache
from pathlib import Path
from typing import Any

import onigurumacffi
import pytest
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String

from cortex_dsl.editor import textmate
from cortex_dsl.editor.lexer import ScnLexer
from cortex_dsl.syntax.words import KEYWORDS
from cortex_dsl.version import VERSION

ROOT = Path(__file__).parents[3]
EDITORS = ROOT / "editors"
EXAMPLES = sorted((ROOT / "examples").glob("*.scn"))
COLOURS = {
    "comment": Comment.Single,
    "string.quoted.docstring": String.Doc,
    "string": String,
    "constant.numeric": Number,
    "keyword.other.unit": Keyword.Type,
    "keyword.operator.word": Operator.Word,
    "keyword.operator": Operator,
    "keyword.control": Keyword,
    "storage.type": Keyword.Declaration,
    "constant.language": Keyword.Constant,
    "variable.language": Name.Builtin.Pseudo,
    "variable.other.assignment": Name.Variable,
    "variable.parameter.lambda": Name,
    "variable.parameter": Name.Variable,
    "variable.other.property": Name.Attribute,
    "entity.name.label": Name.Label,
    "entity.name.type.class": Name.Class,
    "entity.name.function": Name.Function,
    "support.function": Name.Builtin,
}
"""The token of each scope, the first that fits."""
COMPLETE = '''"""Every construct once."""
from cars import Taxi, slow as crawl
import "lib/cars.scn" as c
signals(green=20 s, yellow=3 s)
class Van(Car):
    """A van."""
    speed: Range(3, 9) m/s
monitor Watch(limit):
    while True:
        require (distance to adv) > limit
        wait
scenario Main(x=3):
    precondition: ego.speed > 3 m/s
    setup:
        override ego with behavior B()
        mutate ego, adv by 2
    compose:
        do choose {a: 1, b: 2}
        do a for 5 seconds
require always (distance to adv) > 3 m
require eventually ego in road implies next (ego can see adv)
require monitor Watch(3 m)
require[0.5] x offset by (1, 2) in road as "hello"
record initial ego.speed as v0
terminate simulation when x
record = 3
f = lambda m: m.type is ManeuverType.STRAIGHT  # why
ego = new Car ahead of x by 3 m, facing toward adv, behind truck by 2, left of b
if x: take SetBrakeAction(1), SetThrottleAction(0.5)
y = x deg + 0.3 g * 3 m/s^2 - (1, 2) @ 3
z = """text
over \\""" lines""" + 'a' + none + None
'''


# -- the reader -------------------------------------------------------------------------------------------------------


Rule = dict[str, Any]
Scopes = list[str]
"""The scope of every character of a text; "" for none."""


@cache
def compiled(pattern: str) -> Any:
    return onigurumacffi.compile(pattern)


def flattened(grammar: Rule, rules: list[Rule]) -> list[Rule]:
    """Rules with what they include, blocks excepted."""
    flat: list[Rule] = []
    for rule in rules:
        if "include" in rule:
            flat += flattened(grammar, grammar["repository"][rule["include"][1:]]["patterns"])
        else:
            flat.append(rule)
    return flat


def earliest(rules: list[Rule], line: str, start: int) -> tuple[Rule, Any] | None:
    found = [(rule, compiled(rule.get("match") or rule["begin"]).search(line, start)) for rule in rules]
    fitting = [(rule, match) for rule, match in found if match is not None]
    return min(fitting, key=lambda pair: pair[1].start(), default=None)


def paint(scopes: Scopes, offset: int, start: int, end: int, name: str) -> None:
    for index in range(offset + start, offset + end):
        scopes[index] = name


def coloured(grammar: Rule, text: str) -> Scopes:
    """The innermost scope of every character."""
    scopes, offset, block = [""] * len(text), 0, None
    top = flattened(grammar, grammar["patterns"])
    for line in text.splitlines(keepends=True):
        at = 0
        while at < len(line):
            if block is not None:
                end = compiled(block["end"]).search(line, at)
                escape = compiled(r"\\[\s\S]").search(line, at)
                if escape is not None and (end is None or escape.start() < end.start()):
                    paint(scopes, offset, at, escape.end(), block["name"])
                    at = escape.end()
                    continue
                stop = len(line) if end is None else end.end()
                paint(scopes, offset, at, stop, block["name"])
                at, block = stop, block if end is None else None
                continue
            hit = earliest(top, line, at)
            if hit is None:
                break
            rule, match = hit
            if rule.get("name"):
                paint(scopes, offset, match.start(), match.end(), rule["name"])
            for group, capture in rule.get("captures", {}).items():
                if match.start(int(group)) >= 0:
                    paint(scopes, offset, match.start(int(group)), match.end(int(group)), capture["name"])
            block = rule if "begin" in rule else None
            at = match.end() if match.end() > match.start() else match.end() + 1
        offset += len(line)
    return scopes


# -- what holds -------------------------------------------------------------------------------------------------------


def token_of(scope):
    return next((token for name, token in COLOURS.items() if scope.startswith(name)), None)


def disagreements(text):
    """Words that the two colour differently; plain names and punctuation have no scope."""
    scopes = coloured(textmate.build(), text)
    for start, token, value in ScnLexer().get_tokens_unprocessed(text):
        for index in (i for i in range(start, start + len(value)) if not text[i].isspace()):
            expected = None if token in Punctuation or token is Name else token
            actual = token_of(scopes[index])
            if (None if actual is Name else actual) is not expected:
                yield value, text[index], token, scopes[index]
                break


def test_the_file_is_what_the_command_writes():
    assert textmate.PATH.read_text(encoding="utf-8") == textmate.text()


@pytest.mark.parametrize(
    "text", [*(path.read_text() for path in EXAMPLES), COMPLETE], ids=[*(p.stem for p in EXAMPLES), "-"]
)
def test_it_colours_as_the_lexer_does(text):
    assert list(disagreements(text)) == []


@pytest.mark.parametrize("keyword", KEYWORDS, ids=lambda k: f"{k.role.value}-{k.phrase}")
def test_it_colours_every_form_as_the_lexer_does(keyword):
    before = "" if keyword.role.value in ("statement", "act", "clause") else "x = y, "
    assert list(disagreements(f"{before}{keyword.form}\n")) == []


def test_the_extension_names_files_that_exist():
    manifest = json.loads((EDITORS / "package.json").read_text())
    assert manifest["version"] == VERSION
    (language,), (grammar,) = manifest["contributes"]["languages"], manifest["contributes"]["grammars"]
    for path in (language["configuration"], grammar["path"], manifest["main"]):
        assert (EDITORS / path).is_file()
    assert grammar["scopeName"] == textmate.SCOPE
    assert json.loads((EDITORS / language["configuration"]).read_text())["comments"] == {"lineComment": "#"}
