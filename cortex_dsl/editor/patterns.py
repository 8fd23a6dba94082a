"""The words of the language as regular expressions, for the lexer and for the TextMate grammar.

Everything is made from the tables: a new builtin, unit or keyword is coloured without further code. The expressions use
only syntax that Python and Oniguruma read the same way.
"""

import re
from collections.abc import Iterable

from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, Kind
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import CONSTANT_WORDS, RESERVED, Keyword, Role, with_role

NAME = r"[^\W\d]\w*"
BLANK = r"[ \t\f]"
_OPERAND = rf"(?={BLANK}+(?!(?:and|as|else|for|if|in|is|not[ \t]+in|or|until)\b)(?:[\w(\[{{\"']|[-+]\S))"
"""Pattern after a word that is a keyword by position: a blank and a value."""
_NO_NAME = rf"(?![(\[]|{BLANK}*(?:[.,)\]}}]|(?:\*\*|//|[-+*/%@<>!=])?=)|{BLANK}+(?:and|as|if|in|is|or)\b)"
"""Pattern that must not follow the first word of a statement; if it does, as in `record = 3`, the word is a name."""


def one_of(words: Iterable[str]) -> str:
    """Return a pattern for one of several words, the longest match first."""
    return "(?:" + "|".join(re.escape(word) for word in sorted(words, key=lambda w: (-len(w), w))) + ")"


def _phrase(keyword: Keyword, guard: str) -> str:
    """Return a pattern for words in a row; a single unreserved word needs a guard, since it may be a name."""
    free = len(keyword.words) == 1 and keyword.phrase not in RESERVED
    return rf"{BLANK}+".join(keyword.words) + r"\b" + (guard if free else "")


def _phrases(*roles: Role, guard: str = "") -> str:
    return "(?:" + "|".join(dict.fromkeys(_phrase(keyword, guard) for keyword in with_role(*roles))) + ")"


def _begins(*roles: Role) -> str:
    """Return a pattern for statements; a statement in the form of a call needs its bracket."""
    called = [k.phrase for k in with_role(*roles) if k.form.startswith(f"{k.phrase}(")]
    usual = _phrases(*roles, guard=_NO_NAME)
    return rf"(?:{one_of(called)}(?={BLANK}*\()|{usual})" if called else usual


STATEMENT = _begins(Role.STATEMENT, Role.ACT, Role.CLAUSE)
SPECIFIER = _phrases(Role.SPECIFIER, guard=_OPERAND)
OPERATOR = _phrases(Role.OPERATOR, guard=_OPERAND)
LINK = rf"(?:{one_of(RESERVED - {*CONSTANT_WORDS})}\b|{_phrases(Role.LINK, guard=_NO_NAME)})"
"""Words inside a statement that join its parts; a reserved word is a keyword everywhere."""
DEFINITION = rf"(behavior|monitor|scenario)({BLANK}+)(?!(?:and|as|for|if|in|is|not|or)\b)({NAME})"
"""Definition of a name: the keyword, the blank and the name."""
CONSTANT = rf"{one_of(CONSTANT_WORDS)}\b"
SPECIAL = rf"{one_of(SPECIAL_NAMES)}\b"
ASSIGNED = rf"{NAME}(?={BLANK}*(?:,{BLANK}*{NAME}{BLANK}*)*(?:\*\*|//|[-+*/%])?=(?!=))"
NAMED_ARGUMENT = rf"{NAME}(?={BLANK}*=(?!=))"
NUMBER = r"(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?"
UNIT = rf"{one_of(UNIT_WORDS)}(?![\w^²])"
SIGN = r"\*\*=?|//=?|[-+*/%]=?|[<>=!]=|[<>=@]"


def builtins(*kinds: Kind) -> str:
    return rf"{one_of(b.name for b in BUILTINS.values() if b.kind in kinds)}\b"
