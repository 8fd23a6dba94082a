"""Colours of `.scn` text, for Pygments and programs based on it (rich, prompt_toolkit, Sphinx).

The words of the language are regular expressions here, for the TextMate grammar too. The module also splits a text into
tokens with their places, for editors.
"""

import re
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, default, include
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Whitespace, _TokenType

from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES, Kind
from cortex_dsl.source import Span
from cortex_dsl.syntax import words
from cortex_dsl.syntax.literals import UNIT_WORDS
from cortex_dsl.syntax.words import CONSTANT_WORDS, RESERVED, Role, with_role

# -- words of the language as regular expressions ----------------------------------------------------------------------


NAME = r"[^\W\d]\w*"
BLANK = r"[ \t\f]"
_OPERAND = rf"(?={BLANK}+(?!(?:and|as|else|for|if|in|is|not[ \t]+in|or|until)\b)(?:[\w(\[{{\"']|[-+]\S))"
"""Pattern after a word that is a keyword by position: a blank and a value."""
_NO_NAME = rf"(?![(\[]|{BLANK}*(?:[.,)\]}}]|(?:\*\*|//|[-+*/%@<>!=])?=)|{BLANK}+(?:and|as|if|in|is|or)\b)"
"""Pattern that must not follow the first word of a statement; if it does, as in `record = 3`, the word is a name."""


def one_of(words: Iterable[str]) -> str:
    """Return a pattern for one of several words, the longest match first."""
    return "(?:" + "|".join(re.escape(word) for word in sorted(words, key=lambda w: (-len(w), w))) + ")"


def _phrase(keyword: words.Keyword, guard: str) -> str:
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
INSTANT = rf"(?:{'|'.join(_phrase(k, '') for k in with_role(Role.LINK) if len(k.words) > 1)})(?={BLANK}+in\b)"
"""Instants of a `domain`, which are names before anything but `in`."""
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


class ScnLexer(RegexLexer):
    """Lexer of scenarios.

    Its root state is the beginning of a statement. A statement lasts until its line does, or until the colon before a
    block; inside brackets neither ends it.
    """

    name = "cortexc scenario"
    aliases: ClassVar = ["scn", "cortexc"]
    filenames: ClassVar = ["*.scn"]
    mimetypes: ClassVar = ["text/x-scn"]

    tokens: ClassVar = {
        "root": [
            (r"[\s\ufeff]+", Whitespace),
            (r'"""(?:[^\\]|\\[\s\S])*?(?:"""|\Z)', String.Doc, "statement"),
            (r"'''(?:[^\\]|\\[\s\S])*?(?:'''|\Z)", String.Doc, "statement"),
            (r"#[^\n]*", Comment.Single),
            (
                rf"(param)({BLANK}+)({NAME})(?={BLANK}*=)",
                bygroups(Keyword.Declaration, Whitespace, Name.Variable),
                "statement",
            ),
            (rf"(class)({BLANK}+)({NAME})", bygroups(Keyword.Declaration, Whitespace, Name.Class), "statement"),
            (DEFINITION, bygroups(Keyword.Declaration, Whitespace, Name.Function), "statement"),
            (STATEMENT, Keyword, "statement"),
            (rf"(?!{LINK}){ASSIGNED}", Name.Variable, "statement"),
            (rf"(?!{LINK})({NAME})({BLANK}*)(:)", bygroups(Name.Attribute, Whitespace, Punctuation)),
            default("statement"),
        ],
        "statement": [
            (r"\r?\n", Whitespace, "#pop"),
            (r"[:;]", Punctuation, "#pop"),
            include("inside"),
        ],
        "inside": [
            (rf"(?:{BLANK}|\ufeff|\\\r?\n|\r)+", Whitespace),
            (r"#[^\n]*", Comment.Single),
            include("strings"),
            include("numbers"),
            include("words"),
            include("names"),
            (r"[(\[{]", Punctuation, "brackets"),
            (r"[)\]}]", Punctuation),
            (SIGN, Operator),
            (r"[,.]", Punctuation),
        ],
        "brackets": [
            (r"\n", Whitespace),
            (rf"(\))({BLANK}*)({UNIT})", bygroups(Punctuation, Whitespace, Keyword.Type), "#pop"),
            (r"[)\]}]", Punctuation, "#pop"),
            (r":", Punctuation),
            (NAMED_ARGUMENT, Name.Variable),
            include("inside"),
        ],
        "lambda": [
            (r":", Punctuation, "#pop"),
            (r"(?=[\n)\]}])", Whitespace, "#pop"),
            (r"[,\s]", Punctuation),
            (NAME, Name),
            default("#pop"),
        ],
        "strings": [
            (r'[fF]?"""(?:[^\\]|\\[\s\S])*?(?:"""|\Z)', String),
            (r"[fF]?'''(?:[^\\]|\\[\s\S])*?(?:'''|\Z)", String),
            (r'[fF]?"(?:[^"\\\n]|\\[^\n])*"?', String),
            (r"[fF]?'(?:[^'\\\n]|\\[^\n])*'?", String),
        ],
        "numbers": [
            (rf"({NUMBER})({BLANK}*)({UNIT})", bygroups(Number, Whitespace, Keyword.Type)),
            (NUMBER, Number),
        ],
        "words": [
            (r"lambda\b", Keyword, "lambda"),
            (rf"(new)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Class)),
            (rf"(with)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Attribute)),
            (rf"(as)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Label)),
            (rf"(\.)({BLANK}*)({NAME})", bygroups(Operator, Whitespace, Name.Attribute)),
            (CONSTANT, Keyword.Constant),
            (r"deg\b", Keyword.Type),
            (INSTANT, Keyword),
            (OPERATOR, Operator.Word),
            (SPECIFIER, Keyword),
            (LINK, Keyword),
        ],
        "names": [
            (SPECIAL, Name.Builtin.Pseudo),
            (builtins(Kind.FUNCTION, Kind.DISTRIBUTION), Name.Builtin),
            (builtins(Kind.ACTION, Kind.BEHAVIOUR), Name.Function),
            (builtins(Kind.CLASS), Name.Class),
            (builtins(Kind.CONSTANT), Name.Builtin.Pseudo),
            (NAME, Name),
        ],
    }


# -- A text as the lexer sees it, with offsets: the token at a place, also in broken text ------------------------------

_WORD = re.compile(r"[^\W\d]\w*")
_LEXER = ScnLexer()


@dataclass(frozen=True)
class Token:
    kind: _TokenType
    text: str
    start: int

    @property
    def end(self) -> int:
        return self.start + len(self.text)

    @property
    def span(self) -> Span:
        return Span(self.start, self.end)

    @property
    def is_name(self) -> bool:
        return self.kind in Name and _WORD.fullmatch(self.text) is not None

    @property
    def is_keyword(self) -> bool:
        return (self.kind in Keyword or self.kind is Operator.Word) and not self.is_unit

    @property
    def is_unit(self) -> bool:
        return self.kind is Keyword.Type

    @property
    def is_text(self) -> bool:
        return self.kind in Comment or self.kind in String


def tokens_of(text: str) -> tuple[Token, ...]:
    """Return all tokens except blanks."""
    found = _LEXER.get_tokens_unprocessed(text)
    return tuple(Token(kind, value, start) for start, kind, value in found if kind is not Whitespace and value.strip())


def index_at(tokens: Sequence[Token], offset: int) -> int:
    """Index of the token that an offset lies in or at the end of, the right one first; -1 if it lies in none."""
    index = bisect_right(tokens, offset, key=lambda token: token.start) - 1
    if index >= 0 and offset < tokens[index].end:
        token = tokens[index]
        before = tokens[index - 1] if index else None
        ends_word = before is not None and before.end == offset and before.text[-1:].isalnum()
        return index - 1 if ends_word and offset == token.start and not token.text[0].isalnum() else index
    return index if index >= 0 and offset == tokens[index].end else -1


def word_before(text: str, offset: int) -> str:
    """The part of a word that ends at an offset."""
    found = re.search(r"\w*\Z", text[:offset])
    return found.group() if found else ""
