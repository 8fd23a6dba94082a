"""Colours of the language: one table for input and listings."""

from pygments.token import Comment, Keyword, Name, Number, Operator, String, _TokenType
from rich.text import Text

from cortex_dsl.editor.lexer import ScnLexer

STYLES: dict[_TokenType, str] = {
    Comment: "bright_black",
    String: "green",
    Number: "cyan",
    Keyword: "bold blue",
    Keyword.Type: "cyan",
    Keyword.Constant: "cyan",
    Operator.Word: "blue",
    Name.Class: "yellow",
    Name.Function: "magenta",
    Name.Builtin: "magenta",
    Name.Builtin.Pseudo: "yellow",
    Name.Variable: "bold",
    Name.Attribute: "",
    Name.Label: "green",
}
"""The terminal's own sixteen colours, by the words of rich."""


def coloured(text: str) -> Text:
    """A text in colours."""
    result = Text(text)
    for start, kind, value in ScnLexer().get_tokens_unprocessed(text):
        if style := next((STYLES[each] for each in reversed(kind.split()) if each in STYLES), ""):
            result.stylize(style, start, start + len(value))
    return result


def for_prompt() -> list[tuple[_TokenType, str]]:
    """Return the table in the words of prompt_toolkit."""
    return [(kind, " ".join(map(_ansi, style.split()))) for kind, style in STYLES.items()]


def _ansi(word: str) -> str:
    return word if word == "bold" else "ansi" + word.replace("_", "")
