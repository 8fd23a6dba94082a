"""A logical line as the formatter sees it: tokens with the text before each, in groups by brackets."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from lark import Token

_OPEN = {"LPAR": ")", "LSQB": "]", "LBRACE": "}"}
_CLOSE = {"RPAR", "RSQB", "RBRACE"}
_ENDS_VALUE = {"NAME", "NUMBER", "STRING", "FSTRING", "CONSTANT", "UNIT", "_DEG", *_CLOSE}
_CALLED = {"_SIMULATION", "_SIGNALS", "_REQUIRE_PROBABLY"}
"""Words that a bracket follows without a space."""
_SIGNED = {"PLUS", "MINUS", "STAR"}
"""Signs that belong to the next token if no value is before them."""
_NEVER_APART = {"COMMA", "_COMMA_SPECIFIER", "COLON", "SEMICOLON", *_CLOSE}
_BINDING = {"_LAMBDA": "COLON", "_FOR": "IN"}
"""Words before names, and the tokens that end those names: the commas between them separate no items."""
_COMMENT = re.compile(r"#[^\n]*")


@dataclass(frozen=True)
class Comment:
    text: str
    alone: bool
    """Whether it has a line of its own."""


@dataclass(frozen=True)
class Piece:
    """A token, and the gap before it."""

    kind: str
    text: str
    space: bool = False
    """Whether a space is before it within a line."""
    comments: tuple[Comment, ...] = ()
    broken: bool = False
    """Whether the author ended a line before it."""
    continued: bool = False
    """Whether that was done with a backslash."""
    pad: int = 0
    """More spaces before it, for alignment."""


@dataclass(frozen=True)
class Group:
    """Brackets with their contents."""

    open: Piece
    nodes: "tuple[Node, ...]"
    close: Piece
    called: bool
    """Whether the brackets are those of a call or an index, and not of a value."""
    takes_comma: bool
    """Whether a comma may follow its last item."""

    @property
    def forced(self) -> bool:
        """Return whether its items get lines of their own: the author broke it open, or it contains a comment."""
        if not self.nodes:
            return bool(self.close.comments)
        opened = leading(self.nodes[0]).broken
        return opened or bool(self.close.comments) or any(is_forced(node) for node in self.nodes)


Node: TypeAlias = Piece | Group


def leading(node: Node) -> Piece:
    """The first token of a node."""
    return node.open if isinstance(node, Group) else node


def is_forced(node: Node) -> bool:
    """Return whether a line must end before or in it."""
    return bool(leading(node).comments) or (isinstance(node, Group) and node.forced)


def comments_in(gap: str) -> tuple[Comment, ...]:
    """The comments between two tokens."""
    return tuple(Comment(tidy(match.group()), "\n" in gap[: match.start()]) for match in _COMMENT.finditer(gap))


def tidy(comment: str) -> str:
    """A comment without space at its end, and with some behind its sign."""
    text = comment.rstrip()
    marks = len(text) - len(text.lstrip("#"))
    return text if marks == len(text) or text[marks] in " \t!:" else f"{text[:marks]} {text[marks:]}"


def nodes_of(tokens: Sequence[Token], text: str) -> tuple[Node, ...]:
    """The tokens of one logical line of a text, in groups."""
    return _grouped(iter(_Pieces(tokens, text).read()), None)[0]


def _grouped(pieces: Iterator[Piece], around: Piece | None) -> tuple[tuple[Node, ...], Piece | None]:
    """Nodes up to the bracket that closes them, and that bracket."""
    nodes: list[Node] = []
    before = around
    for piece in pieces:
        if piece.kind in _CLOSE:
            return tuple(nodes), piece
        if piece.kind in _OPEN:
            inner, close = _grouped(pieces, piece)
            assert close is not None
            called = not piece.space and before is not None and before.kind in _ENDS_VALUE | _CALLED
            nodes.append(Group(piece, inner, close, called, _takes_comma(piece, inner, called, before)))
            before = close
        else:
            nodes.append(piece)
            before = piece
    return tuple(nodes), None


def _takes_comma(opening: Piece, nodes: Sequence[Node], called: bool, before: Piece | None) -> bool:
    kinds = {node.kind for node in nodes if isinstance(node, Piece)}
    if not nodes or "_FOR" in kinds or (before is not None and before.kind == "_FOR"):
        return False
    if opening.kind == "LPAR":
        return "COMMA" in kinds or called
    return opening.kind == "LBRACE" or not called


class _Pieces:
    """One pass over the tokens of a line, with the state that decides about spaces."""

    def __init__(self, tokens: Sequence[Token], text: str) -> None:
        self.tokens = tokens
        self.text = text
        self.bound = set(_bound_commas(tokens))
        self.brackets: list[str] = []
        """For each open bracket the kind of the token before it."""
        self.last = ""
        self.value = False
        """Whether a value has just ended, so that `-` is an operator and `(` a call."""
        self.glued = True
        """Whether what follows stands directly behind."""

    def read(self) -> Iterator[Piece]:
        for number, token in enumerate(self.tokens):
            gap = self.text[self.tokens[number - 1].end_pos : token.start_pos] if number else ""
            kind = "BOUND_COMMA" if number in self.bound else token.type
            spelled = str(token) if kind in ("STRING", "FSTRING") else " ".join(token.split())
            yield Piece(
                kind, spelled, self.space(token.type), comments_in(gap), "\n" in gap, "\\" in _COMMENT.sub("", gap)
            )
            self.step(token.type)

    def space(self, kind: str) -> bool:
        if self.glued or kind in _NEVER_APART:
            return False
        if kind == "DOT":
            return self.last == "NUMBER"
        if kind in ("LPAR", "LSQB"):
            return not self.value and self.last not in _CALLED and not (self.brackets and self.last == "_EQUAL")
        return not (self.brackets and "_EQUAL" in (kind, self.last))

    def step(self, kind: str) -> None:
        self.glued = kind in _OPEN or kind == "DOT" or (kind in _SIGNED and not self.value and self.last != "_IMPORT")
        is_name = (kind, self.last) in (("NAME", "_WITH"), ("STRING", "_DOMAIN"))
        self.value = kind in _ENDS_VALUE and not is_name
        if kind in _OPEN:
            self.brackets.append(self.last)
        elif kind in _CLOSE:
            self.value = self.brackets.pop() != "_REQUIRE_PROBABLY"
        self.last = kind


def _bound_commas(tokens: Sequence[Token]) -> Iterator[int]:
    """Places of the commas between the names of a `lambda` or `for`."""
    for number, token in enumerate(tokens):
        if token.type not in _BINDING:
            continue
        end = number + 1
        while end < len(tokens) and tokens[end].type in ("NAME", "COMMA"):
            end += 1
        if end < len(tokens) and tokens[end].type == _BINDING[token.type]:
            yield from (place for place in range(number, end) if tokens[place].type == "COMMA")
