"""The words of the language as regular expressions, for the lexer and for the TextMate grammar.

Everything is made from the tables: a new builtin, unit or keyword is coloured by being there. The expressions keep to
what Python and Oniguruma read the same way.
"""

import re
from collections.abc import Iterable

from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, Kind
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import CONSTANT_WORDS, RESERVED, Keyword, Role, with_role

NAME = r"[^\W\d]\w*"
BLANK = r"[ \t\f]"
_OPERAND = rf"(?={BLANK}+(?!(?:and|as|else|for|if|in|is|not[ \t]+in|or|until)\b)(?:[\w(\[{{\"']|[-+]\S))"
"""What follows a word that is a keyword by position: a blank and something that has a value."""
_NO_NAME = rf"(?![(\[]|{BLANK}*(?:[.,)\]}}]|(?:\*\*|//|[-+*/%@<>!=])?=)|{BLANK}+(?:and|as|if|in|is|or)\b)"
"""What does not follow a word that begins a statement; where it does, as in `record = 3`, the word is a name."""


def one_of(words: Iterable[str]) -> str:
    """One of several words, the longest that fits."""
    return "(?:" + "|".join(re.escape(word) for word in sorted(words, key=lambda w: (-len(w), w))) + ")"


def _phrase(keyword: Keyword, guard: str) -> str:
    """Words in a row; a single one that is not reserved needs a guard, for it may be a name."""
    free = len(keyword.words) == 1 and keyword.phrase not in RESERVED
    return rf"{BLANK}+".join(keyword.words) + r"\b" + (guard if free else "")


def _phrases(*roles: Role, guard: str = "") -> str:
    return "(?:" + "|".join(dict.fromkeys(_phrase(keyword, guard) for keyword in with_role(*roles))) + ")"


def _begins(*roles: Role) -> str:
    """Statements; one that is written like a call needs its bracket."""
    called = [k.phrase for k in with_role(*roles) if k.form.startswith(f"{k.phrase}(")]
    usual = _phrases(*roles, guard=_NO_NAME)
    return rf"(?:{one_of(called)}(?={BLANK}*\()|{usual})" if called else usual


STATEMENT = _begins(Role.STATEMENT, Role.ACT, Role.CLAUSE)
SPECIFIER = _phrases(Role.SPECIFIER, guard=_OPERAND)
OPERATOR = _phrases(Role.OPERATOR, guard=_OPERAND)
LINK = rf"(?:{one_of(RESERVED - {*CONSTANT_WORDS})}\b|{_phrases(Role.LINK, guard=_NO_NAME)})"
"""Words inside a statement that join its parts; a reserved word is a keyword wherever it stands."""
DEFINITION = rf"(behavior|monitor|scenario)({BLANK}+)(?!(?:and|as|for|if|in|is|not|or)\b)({NAME})"
"""What defines a name: the keyword, the blank and the name."""
CONSTANT = rf"{one_of(CONSTANT_WORDS)}\b"
SPECIAL = rf"{one_of(SPECIAL_NAMES)}\b"
ASSIGNED = rf"{NAME}(?={BLANK}*(?:,{BLANK}*{NAME}{BLANK}*)*(?:\*\*|//|[-+*/%])?=(?!=))"
NAMED_ARGUMENT = rf"{NAME}(?={BLANK}*=(?!=))"
NUMBER = r"(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?"
UNIT = rf"{one_of(UNIT_WORDS)}(?![\w^²])"
SIGN = r"\*\*=?|//=?|[-+*/%]=?|[<>=!]=|[<>=@]"


def builtins(*kinds: Kind) -> str:
    return rf"{one_of(b.name for b in BUILTINS.values() if b.kind in kinds)}\b"
