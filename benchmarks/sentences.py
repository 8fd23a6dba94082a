"""Random sentences of the language, drawn from its own grammar file: shaped right, and mostly without sense."""

import random
from collections import defaultdict
from functools import cache

from lark.grammar import NonTerminal, Rule, Terminal

from cortex_dsl.semantics.names.builtins import BUILTINS
from cortex_dsl.semantics.names.properties import all_properties
from cortex_dsl.syntax import parser

DEPTH = 7
"""Beyond this, every rule takes its shortest way out."""
NAMES = ("x", "y", "ego", "car", "lane", "self", "P", "Q", "trajectory", "intersection", "network")
WORDS: dict[str, tuple[str, ...]] = {
    "NUMBER": ("0", "1", "2.5", "90", "1e3", "1e308", ".5", "-0"),
    "STRING": ('"text"', "'a'", '"""doc"""', '"cars.scn"'),
    "UNIT": ("m", "km/h", "s", "deg", "m/s", "m/s^2", "g", "kg", "Hz"),
    "UNKNOWN_UNIT": ("kmh", "metres"),
    "CONSTANT": ("True", "False", "None"),
    "COMPARE": ("<", "<=", "==", ">", ">=", "!="),
    "AUGMENTED_ASSIGN": ("+=", "-=", "*=", "/="),
    "TEMPORAL": ("always", "eventually", "next"),
    "TIME_WORD": ("seconds", "steps"),
    "BESIDE": ("ahead of", "behind", "left of", "right of"),
    "DISTANCE": ("distance", "minimum distance"),
    "IS_NOT": ("is not",),
    "NOT_IN": ("not in",),
    "_COMMA_SPECIFIER": (",",),
    "_EQUAL": ("=",),
    "_RELATIVE_HEADING_OF": ("relative heading of",),
    "_RELATIVE_TO": ("relative to",),
    "APPARENT_OR_POSITION": ("apparent heading of", "relative position of"),
    "DISTANCE_PAST": ("distance past",),
    "ANGLE": ("angle",),
    "SIDE_OF": ("front of", "back left of", "right of"),
    "VISIBLE": ("visible", "not visible"),
    "IN_SIGHT": ("visible", "not visible"),
    "_CONTAINED_IN": ("contained in",),
    "_APPARENTLY_FACING": ("apparently facing",),
    "_REQUIRE_PROBABLY": ("require",),
    "_OFFSET_BY": ("offset by",),
    "_OFFSET_ALONG": ("offset along",),
    "_CAN_SEE": ("can see",),
    "_FACING_TOWARD": ("facing toward",),
    "_FACING_AWAY": ("facing away from",),
    "_INTERRUPT_WHEN": ("interrupt when",),
    "_TERMINATE_WHEN": ("terminate when", "terminate simulation when"),
    "_TERMINATE_AFTER": ("terminate after",),
}


class Sentences:
    """Draws programs of some statements, with layout."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng
        self._rules, self._cost = _grammar()
        self._names = [*NAMES, *BUILTINS, *all_properties()]

    def program(self) -> str:
        """A few statements, half of them behind a start that makes sense."""
        start = "map intersection(ways=4)\nego = new Car at 1.75 @ -20\n" if self._rng.random() < 0.5 else ""
        words: list[str] = []
        for _ in range(self._rng.randrange(1, 8)):
            self._expand("_statement", 0, words)
        return start + self._laid_out(words)

    def _expand(self, symbol: str, depth: int, words: list[str]) -> None:
        ways = self._rules[symbol]
        if depth > DEPTH:
            least = min(self._price(way) for way in ways)
            ways = [way for way in ways if self._price(way) == least]
        for part in self._rng.choice(ways).expansion:
            if isinstance(part, NonTerminal):
                self._expand(part.name, depth + 1, words)
            else:
                words.append(self._word(part))

    def _price(self, way: Rule) -> int:
        return max((self._cost.get(part.name, 0) for part in way.expansion if isinstance(part, NonTerminal)), default=0)

    def _word(self, terminal: Terminal) -> str:
        name = terminal.name
        if name in ("_NEWLINE", "_INDENT", "_DEDENT"):
            return name
        if name == "NAME":
            return self._rng.choice(self._names)
        if name in WORDS:
            return self._rng.choice(WORDS[name])
        return _plain_words().get(name) or name.strip("_").lower().replace("_", " ")

    def _laid_out(self, words: list[str]) -> str:
        text, depth, fresh = "", 0, True
        for word in words:
            if word == "_INDENT":
                depth += 1
            elif word == "_DEDENT":
                depth -= 1
            elif word == "_NEWLINE":
                text, fresh = text + "\n", True
            else:
                text, fresh = text + ("    " * depth if fresh else " ") + word, False
        return text + "\n"


@cache
def _grammar() -> tuple[dict[str, list[Rule]], dict[str, int]]:
    """Ways to expand each rule, and how deep the shallowest of them goes."""
    lark, _ = parser._parser()
    rules: dict[str, list[Rule]] = defaultdict(list)
    for rule in lark.rules:
        rules[rule.origin.name].append(rule)
    cost: dict[str, int] = {}
    while len(cost) < len(rules):
        for name, ways in rules.items():
            depths = [
                max((cost[p.name] for p in way.expansion if isinstance(p, NonTerminal)), default=0)
                for way in ways
                if all(p.name in cost for p in way.expansion if isinstance(p, NonTerminal))
            ]
            if depths and name not in cost:
                cost[name] = 1 + min(depths)
    return dict(rules), cost


@cache
def _plain_words() -> dict[str, str]:
    """Terminals whose pattern is a plain text."""
    lark, _ = parser._parser()
    return {t.name: t.pattern.value for t in lark.terminals if type(t.pattern).__name__ == "PatternStr"}
