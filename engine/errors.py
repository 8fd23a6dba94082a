"""The exceptions of cortexc. Exceptions for users are `CortexError`s; exceptions for control flow are `Signal`s.

A `CortexError` has the problem (`message`) and the remedy (`cure`); it can be pickled, so that it passes unchanged from
a worker's process. For an unknown name, the cure offers the `nearest` existing name.
"""

from collections import Counter
from collections.abc import Generator, Iterable, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import lru_cache
from heapq import nlargest
from itertools import islice
from operator import index
from pathlib import Path
from typing import Any


class CortexError(Exception):
    """Base of every exception that a user may catch: the problem and the remedy."""

    def __init__(self, message: str, cure: str = "") -> None:
        super().__init__(message, cure)
        self.message = message
        self.cure = cure

    def __str__(self) -> str:
        return f"{self.message} ({self.cure})" if self.cure else self.message

    def __reduce__(self) -> tuple[Any, ...]:
        # Without `__init__`: a subclass takes other arguments than these, but stores its data as attributes.
        return _restored, (type(self), self.args), self.__dict__


def _restored(kind: type[CortexError], arguments: tuple[Any, ...]) -> CortexError:
    return kind.__new__(kind, *arguments)


SHORTEST_BEGINNING = 4
"""Least number of letters of a word that counts as the beginning of a longer word."""

ENDINGS = ("behavior", "action", "region")
"""Common endings of names, which are ignored in a comparison of names."""

MOST_COMPARED = 300
"""Maximum number of names that are all compared with a misspelt name; of more, the most similar ones are compared."""


def nearest(word: str, candidates: Iterable[str]) -> str | None:
    """Return the candidate that `word` was probably meant to be, or None if none is near."""
    return _nearest(word, frozenset(candidates))


@lru_cache(maxsize=8)
def _nearest(word: str, candidates: frozenset[str]) -> str | None:
    """Return the nearest candidate; cached, as one mistake queries repeatedly, and thousands of names take long."""
    by_folded, by_pair = _index(candidates)
    folded = word.lower()
    begun = [candidate for candidate in by_folded if len(folded) >= SHORTEST_BEGINNING and candidate.startswith(folded)]
    if begun:
        return by_folded[min(begun, key=len)]
    few = by_folded if len(by_folded) <= MOST_COMPARED else _most_alike(folded, by_folded, by_pair)
    if len(folded) > 2 and (swapped := [each for each in few if sorted(each) == sorted(folded)]):
        return by_folded[min(swapped)]
    matches = get_close_matches(folded, few, n=3, cutoff=0.6)
    return next((by_folded[match] for match in matches if _is_a_slip(folded, match)), None)


def _is_a_slip(word: str, meant: str) -> bool:
    """Return True if one word extends the other, or few letters differ; in three or four letters, one letter."""
    ending = next((each for each in ENDINGS if word.endswith(each) and meant.endswith(each)), "")
    word, meant = word.removesuffix(ending), meant.removesuffix(ending)
    if len(meant) >= SHORTEST_BEGINNING and (word.startswith(meant) or word.endswith(meant)):
        return True
    if len(word) >= SHORTEST_BEGINNING and word in meant.split("_"):
        return True
    letters, edits = max(len(word), len(meant)), _edits(word, meant)
    # Words with equal beginnings may differ in more letters.
    alike = word[: SHORTEST_BEGINNING - 1] == meant[: SHORTEST_BEGINNING - 1]
    return edits <= max(1, (letters + (2 if alike else -1)) // 3)


def _edits(a: str, b: str) -> int:
    """Return the number of inserted, removed, replaced and swapped letters (optimal string alignment distance)."""
    before, last = [0], list(range(len(b) + 1))
    for i, x in enumerate(a):
        row = [i + 1]
        for j, y in enumerate(b):
            row.append(min(last[j + 1] + 1, row[j] + 1, last[j] + (x != y)))
            if i and j and x == b[j - 1] and y == a[i - 1]:
                row[-1] = min(row[-1], before[j - 1] + 1)
        before, last = last, row
    return last[-1]


@lru_cache(maxsize=4)
def _index(candidates: frozenset[str]) -> tuple[Mapping[str, str], Mapping[str, Sequence[str]]]:
    """Return candidates by their small letters, and by each pair of adjacent letters in them."""
    by_folded = {candidate.lower(): candidate for candidate in sorted(candidates)}
    by_pair: dict[str, list[str]] = {}
    for folded in by_folded if len(by_folded) > MOST_COMPARED else ():
        for pair in _pairs(folded):
            by_pair.setdefault(pair, []).append(folded)
    return by_folded, by_pair


def _pairs(word: str) -> set[str]:
    return {word[i : i + 2] for i in range(len(word) - 1)}


def _most_alike(word: str, candidates: Iterable[str], by_pair: Mapping[str, Sequence[str]]) -> list[str]:
    """Return the candidates with most adjacent pairs of letters in common with a word; whole comparisons take
    milliseconds.
    """
    shared = Counter(each for pair in _pairs(word) for each in by_pair.get(pair, ()))
    among = shared if len(shared) >= MOST_COMPARED else candidates
    return nlargest(MOST_COMPARED, among, key=lambda each: (shared[each], -len(each), each))


class Signal(Exception):  # noqa: N818 - no error, it is caught where it is expected
    """Control flow between two modules; never reaches a user."""


class ArgumentError(CortexError, ValueError):
    """An argument has an invalid value; the message has its name, the expectation and the value."""


class ArgumentKindError(CortexError, TypeError):
    """An argument is of an unexpected type, or has an unknown name."""


class ControllerError(CortexError):
    """A controller cannot be queried, returns invalid actions, or is missing where it is required."""

    def __init__(self, message: str, cure: str = "", what: str = "", kind: str = "") -> None:
        super().__init__(message, cure)
        self.what = what or message
        """Message without the place."""
        self.raised: BaseException | None = None
        """Exception of the controller's code, if it is the cause."""
        self.kind = kind or self.what
        """Message without all variable parts: equal for equal kinds of failures."""

    def at(self, where: str) -> "ControllerError":
        """Return the error with the scene and the time of the failure."""
        placed = type(self)(f"{self.what}, {where}", self.cure, self.what, self.kind)
        placed.raised = self.raised
        return placed


class LostError(ControllerError):
    """A controller failed in some scenes; it may succeed in other scenes, or in a repetition."""

    def for_good(self) -> ControllerError:
        """Return the final error, without a repetition."""
        final = ControllerError(self.message, self.cure, self.what, self.kind)
        final.raised = self.raised
        return final


class RowError(CortexError, IndexError):
    """There is no such row."""


class UnreadableFileError(CortexError, OSError):
    """A file cannot be read; its `errno` and `filename` are those of the system's error."""

    def __init__(self, path: str | Path, error: OSError) -> None:
        reason = (error.strerror or str(error)).lower()
        super().__init__(f"cannot read `{path}`: {reason}", "name a file that is there and may be read")
        self.errno, self.filename = error.errno, str(path)


class HiddenEngineError(CortexError, ImportError):
    """A different package or folder named `engine` precedes this package, so that nothing can be run."""

    def __init__(self, home: Path, found: str) -> None:
        super().__init__(
            f"its package `engine` should be at {home} but was found {found}",
            "another package or folder called `engine` hides it; install cortexc in an environment of its own",
        )

    def __str__(self) -> str:
        return f"cortexc: {super().__str__()}"


# -- files of other tools --------------------------------------------------------------------------------------------

MOST_CHOICES = 12
MOST_NAMES = 2000
"""Maximum number of names with which an unknown name is compared."""
MOST_LETTERS = 60
"""Largest length of a quoted text from another tool's file."""


class InterchangeError(CortexError):
    """A file cannot be read, or a format cannot express a case; the error has the reason, the place and the cure."""

    def __init__(self, message: str, cure: str, place: str = "") -> None:
        super().__init__(message, cure)
        self.place = place
        """File, and line or element if known: `case.xosc, line 12`."""

    def __str__(self) -> str:
        return f"{self.place}: {super().__str__()}" if self.place else super().__str__()


def quoted(text: str) -> str:
    """Return a text from another tool's file in quotes, cut to the length of a message, without control characters."""
    cut = text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "…"
    return '"' + "".join(letter if letter.isprintable() else "?" for letter in cut) + '"'


def cited(name: str) -> str:
    """Return a name from another tool's file between backquotes, cut and cleaned as `quoted` does."""
    return f"`{quoted(name)[1:-1]}`"


@contextmanager
def reading(path: Path, wanted: str = "a recording") -> Generator[None]:
    """Read a file inside this block; errors of the system become an InterchangeError."""
    try:
        if not path.is_file():
            what = "this is not a file" if path.exists() else "there is no such file"
            raise InterchangeError(what, f"name {wanted}", str(path))
        yield
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise InterchangeError(f"it cannot be read: {reason}", "solve that, or copy the file", path.name) from None


def near_name(word: str, names: Iterable[str]) -> str | None:
    """Return the name that `word` was probably meant to be, or None; of both only a bounded part is compared."""
    return nearest(word[:MOST_LETTERS], islice(names, MOST_NAMES))


def name_cure(word: str, names: Iterable[str]) -> str:
    """Return the cure for an unknown name: the nearest name, or all names; "" if there are none."""
    choices = list(islice(dict.fromkeys(names), MOST_NAMES))
    if near := near_name(word, choices):
        return f"did you mean `{near}`?"
    if not choices:
        return ""
    rest = " and others" if len(choices) > MOST_CHOICES else ""
    verb = "is" if len(choices) == 1 else "are"
    return f"there {verb} " + ", ".join(f"`{name}`" for name in choices[:MOST_CHOICES]) + rest


# -- checks of arguments of Python calls -------------------------------------------------------------------------------

LEFT_OUT = "leave it out for the default"


def whole(name: str, value: object, least: int) -> int:
    """Return the value if it is a whole number (Python or numpy) of at least `least`.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: it is below `least`.
    """
    try:
        number = None if isinstance(value, bool) else index(value)  # type: ignore[arg-type]
    except TypeError:  # an array of several has the method, too
        number = None
    if number is None:
        raise ArgumentKindError(f"{name}: expected a whole number, got {value!r}", LEFT_OUT)
    if number < least:
        raise ArgumentError(f"{name}: expected {least} or more, got {number}", LEFT_OUT)
    return number


def row_of(things: Any, row: int) -> int:
    """Return the index of an existing row, counted from 0.

    Raises:
        RowError: there is no such row.
    """
    if not -len(things) <= whole("row", row, -len(things)) < len(things):
        rows = f"its rows are 0 to {len(things) - 1}" if len(things) else "it has none"
        raise RowError(f"row: there is no {row} in {things!r}", rows)
    return range(len(things))[row]


def kind(name: str, value: object, expected: type | tuple[type, ...], cure: str) -> None:
    """Raise ArgumentKindError if a value is of another type than expected."""
    if not isinstance(value, expected):
        kinds = expected if isinstance(expected, tuple) else (expected,)
        wanted = " or ".join(each.__name__ for each in kinds)
        raise ArgumentKindError(f"{name}: expected {wanted}, got {type(value).__name__}", cure)


def path_of(name: str, value: object, cure: str = "name it by its path") -> Path:
    """Return the value as a path, if a file can have it.

    Raises:
        ArgumentKindError: it is none.
        ArgumentError: no file can have this name.
    """
    kind(name, value, (str, Path), cure)
    if "\0" in str(value):
        raise ArgumentError(f"{name}: no file can be called {str(value)!r}", cure)
    return Path(str(value))
