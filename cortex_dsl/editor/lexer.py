"""Colours of `.scn` text, for Pygments and programs based on it (rich, prompt_toolkit, Sphinx).

The module also splits a text into tokens with their places, for editors.
"""

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, default, include
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Whitespace, _TokenType

from cortex_dsl.editor import patterns
from cortex_dsl.editor.patterns import BLANK, NAME
from cortex_dsl.semantics.names.builtins import Kind
from cortex_dsl.source import Span


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
            (patterns.DEFINITION, bygroups(Keyword.Declaration, Whitespace, Name.Function), "statement"),
            (patterns.STATEMENT, Keyword, "statement"),
            (rf"(?!{patterns.LINK}){patterns.ASSIGNED}", Name.Variable, "statement"),
            (rf"(?!{patterns.LINK})({NAME})({BLANK}*)(:)", bygroups(Name.Attribute, Whitespace, Punctuation)),
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
            (patterns.SIGN, Operator),
            (r"[,.]", Punctuation),
        ],
        "brackets": [
            (r"\n", Whitespace),
            (rf"(\))({BLANK}*)({patterns.UNIT})", bygroups(Punctuation, Whitespace, Keyword.Type), "#pop"),
            (r"[)\]}]", Punctuation, "#pop"),
            (r":", Punctuation),
            (patterns.NAMED_ARGUMENT, Name.Variable),
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
            (rf"({patterns.NUMBER})({BLANK}*)({patterns.UNIT})", bygroups(Number, Whitespace, Keyword.Type)),
            (patterns.NUMBER, Number),
        ],
        "words": [
            (r"lambda\b", Keyword, "lambda"),
            (rf"(new)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Class)),
            (rf"(with)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Attribute)),
            (rf"(as)({BLANK}+)({NAME})", bygroups(Keyword, Whitespace, Name.Label)),
            (rf"(\.)({BLANK}*)({NAME})", bygroups(Operator, Whitespace, Name.Attribute)),
            (patterns.CONSTANT, Keyword.Constant),
            (r"deg\b", Keyword.Type),
            (patterns.OPERATOR, Operator.Word),
            (patterns.SPECIFIER, Keyword),
            (patterns.LINK, Keyword),
        ],
        "names": [
            (patterns.SPECIAL, Name.Builtin.Pseudo),
            (patterns.builtins(Kind.FUNCTION, Kind.DISTRIBUTION), Name.Builtin),
            (patterns.builtins(Kind.ACTION, Kind.BEHAVIOUR), Name.Function),
            (patterns.builtins(Kind.CLASS), Name.Class),
            (patterns.builtins(Kind.CONSTANT), Name.Builtin.Pseudo),
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
