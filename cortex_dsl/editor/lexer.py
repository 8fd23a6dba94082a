"""Colours of `.scn` text, for Pygments and whatever builds on it: rich, prompt_toolkit, Sphinx."""

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, default, include
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Whitespace

from cortex_dsl.editor import patterns
from cortex_dsl.editor.patterns import BLANK, NAME
from cortex_dsl.semantics.names.builtins import Kind


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
            (r'"""(?:[^\\]|\\[\s\S])*?(?:"""|\Z)', String),
            (r"'''(?:[^\\]|\\[\s\S])*?(?:'''|\Z)", String),
            (r'"(?:[^"\\\n]|\\[^\n])*"?', String),
            (r"'(?:[^'\\\n]|\\[^\n])*'?", String),
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
