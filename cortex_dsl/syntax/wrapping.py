"""Ends of lines in a formatted statement.

A statement is on one line if it fits and its author did not open it: an object with its specifiers on lines of their
own remains so, and so do brackets with a line break after the opening one, or a comment in them. A statement that does
not fit is split at the commas outside brackets, each part on a deeper line, and then bracket by bracket, the outer ones
first; inside them before `and`, `or`, `for`, `if` and `else`.
"""

from collections.abc import Sequence

from cortex_dsl.syntax.pieces import Comment, Group, Node, Piece, leading

WIDTH = 120
STEP = 4
_JOINTS = {"_AND", "_OR", "_FOR", "_IF", "_ELSE"}


def flat(nodes: Sequence[Node]) -> str:
    """Text of nodes on one line."""
    return "".join(_flat(node, first=number == 0) for number, node in enumerate(nodes))


def _flat(node: Node, first: bool) -> str:
    lead = leading(node)
    space = "" if first else " " * (lead.space + lead.pad)
    if isinstance(node, Piece):
        return space + node.text
    return space + node.open.text + flat(_content(node)) + node.close.text


def _content(group: Group) -> Sequence[Node]:
    """The nodes of a group without a comma at its end that changes nothing."""
    commas = sum(isinstance(node, Piece) and node.kind == "COMMA" for node in group.nodes)
    pair = group.open.kind == "LPAR" and not group.called and commas == 1  # `(x,)` is a tuple
    return group.nodes[:-1] if group.takes_comma and _is_comma(group.nodes[-1]) and not pair else group.nodes


def _is_comma(node: Node, *kinds: str) -> bool:
    return isinstance(node, Piece) and node.kind in (kinds or ("COMMA",))


def width(text: str) -> int:
    """Columns of a text up to its first line break."""
    end = text.find("\n")
    return len(text) if end < 0 else end


def separators(nodes: Sequence[Node]) -> list[int]:
    """Places of the commas at which a statement may be parted: those before specifiers, or else those of a list."""
    inner = range(len(nodes) - 1)
    special = [place for place in inner if _is_comma(nodes[place], "_COMMA_SPECIFIER")]
    equals = [place for place in inner if _is_comma(nodes[place], "_EQUAL", "AUGMENTED_ASSIGN")]
    return special or [place for place in inner if _is_comma(nodes[place]) and place > (equals or [-1])[0]]


def is_parted(nodes: Sequence[Node]) -> bool:
    """Return whether the author ended a line after one of its separators."""
    return any(leading(nodes[place + 1]).broken for place in separators(nodes))


def wrap(nodes: Sequence[Node], indent: int) -> str:
    """The lines of a statement, without the last line break."""
    page = _Page(indent, wide=indent + width(flat(nodes)) > WIDTH)
    ends = separators(nodes) if page.wide or is_parted(nodes) else []
    for number, segment in enumerate(_split(nodes, ends)):
        if number:
            page.end_line(leading(segment[0]).comments, indent + STEP)
        page.write(segment, indent + STEP * bool(number), indent + STEP)
    return page.text()


def _split(nodes: Sequence[Node], ends: Sequence[int]) -> list[Sequence[Node]]:
    starts = [0, *(end + 1 for end in ends)]
    return [nodes[start:end] for start, end in zip(starts, [*starts[1:], len(nodes)], strict=True)]


class _Page:
    """Lines in the making."""

    def __init__(self, indent: int, wide: bool) -> None:
        self.wide = wide
        """Whether backslashes at the ends of lines are kept."""
        self.lines: list[str] = []
        self.line = " " * indent
        self.fresh = True
        """Whether nothing stands on the current line yet."""

    def text(self) -> str:
        return "\n".join([*self.lines, self.line])

    @property
    def column(self) -> int:
        return len(self.line) - self.line.rfind("\n") - 1

    def put(self, text: str, lead: Piece) -> None:
        self.line += ("" if self.fresh else " " * (lead.space + lead.pad)) + text
        self.fresh = False

    def end_line(self, comments: Sequence[Comment], indent: int, last: int | None = None) -> None:
        """End the line with its trailing comment, and write the comments on lines of their own."""
        for number, comment in enumerate(comments):
            if number or comment.alone:
                self.new_line(indent)
                self.line += comment.text
            else:
                self.line += "  " + comment.text
        self.new_line(indent if last is None else last)

    def new_line(self, indent: int) -> None:
        self.lines.append(self.line)
        self.line = " " * indent
        self.fresh = True

    def write(self, nodes: Sequence[Node], indent: int, hang: int, after: int = 0) -> None:
        """Write nodes of one stretch, with brackets that close at `indent`; `after` columns are needed after it."""
        for number, node in enumerate(nodes):
            lead = leading(node)
            if lead.comments and not self.fresh:
                self.end_line(lead.comments, hang)
            elif lead.continued and self.wide and not self.fresh and hang > indent - STEP:
                self.line += " \\"
                self.new_line(hang)
            if isinstance(node, Piece):
                self.put(node.text, node)
            elif node.forced or not self.fits(node, nodes[number + 1 :], after):
                self.explode(node, indent)
            else:
                self.put(_flat(node, first=True), lead)

    def fits(self, group: Group, following: Sequence[Node], after: int) -> bool:
        """Return whether a group fits on this line, with the text up to the next bracket."""
        end = next((number for number, node in enumerate(following) if isinstance(node, Group)), len(following))
        rest = width(flat(following[:end])) + (after if end == len(following) else 2)
        return self.column + 1 + width(_flat(group, first=True)) + rest <= WIDTH

    def explode(self, group: Group, indent: int) -> None:
        """A group with its items on lines of their own."""
        self.put(group.open.text, group.open)
        inner = indent + STEP
        comments: tuple[Comment, ...] = ()
        items = _items(group)
        for number, (item, comma) in enumerate(items):
            self.end_line((*comments, *leading(item[0]).comments), inner)
            self.item(item, inner)
            comments = comma.comments if comma is not None else ()
            if number < len(items) - 1 or _ends_in_comma(group, items):
                self.line += ","
        self.end_line((*comments, *group.close.comments), inner, indent)
        self.put(group.close.text, group.close)

    def item(self, nodes: Sequence[Node], indent: int) -> None:
        """An item of a group; at the beginning of a line, its first comments are written already."""
        wide = indent + width(flat(nodes)) + 1 > WIDTH
        ends = [place - 1 for place in range(1, len(nodes)) if _is_comma(nodes[place], *_JOINTS)] if wide else []
        special = [place for place in range(len(nodes)) if _is_comma(nodes[place], "_COMMA_SPECIFIER")] if wide else []
        deeper = STEP if special else 0
        for number, segment in enumerate(_split(nodes, special or ends)):
            if number:
                self.end_line(leading(segment[0]).comments, indent + deeper)
            place = indent + deeper * bool(number)
            self.write(segment, place, indent + deeper, after=1)


def _ends_in_comma(group: Group, items: Sequence[tuple[Sequence[Node], Piece | None]]) -> bool:
    """Return whether a comma is after the last item when the items have lines of their own."""
    written = items[-1][1] is not None
    return (len(items) > 1 or (written and not group.called)) if group.takes_comma else written


def _items(group: Group) -> list[tuple[Sequence[Node], Piece | None]]:
    """The items of a group, each with the comma behind it."""
    places = [place for place, node in enumerate(group.nodes) if _is_comma(node)]
    items = [segment for segment in _split(group.nodes, places) if segment]
    return [
        (segment[:-1], segment[-1]) if isinstance(segment[-1], Piece) and _is_comma(segment[-1]) else (segment, None)
        for segment in items
    ]
