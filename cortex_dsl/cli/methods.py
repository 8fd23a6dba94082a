"""The names behind `--method`, and `cortexc --method list`: every way to search, in one line each."""

import textwrap
from importlib.util import find_spec

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.spelling import nearest
from engine.extras import installing
from engine.search.searchers import SearcherEntry, UnknownMethodError, canonical, known_searchers

WIDTH = 80


def named(text: str) -> tuple[str, ...]:
    """The methods of a list with commas.

    Raises:
        UsageError: one of them is not known.
    """
    try:
        return tuple(canonical(word) for word in text.split(","))
    except UnknownMethodError as error:
        names = [name for method, entry in known_searchers().items() for name in (method, entry.alias) if name]
        near = nearest(error.name, names)
        cure = f"did you mean `{near}`?" if near else "`cortexc --method list` tells them all"
        raise UsageError(f"--method: there is no method `{error.name.strip()}`", cure) from None


def method_list() -> str:
    """A table of names, short names and what they do; what is not installed says so, and how to have it."""
    entries = known_searchers()
    names = {name: f"{name} ({entry.alias})" if entry.alias else name for name, entry in entries.items()}
    width = max(map(len, names.values()))
    lines = []
    for name, entry in entries.items():
        first, *others = [*(textwrap.wrap(entry.summary, WIDTH - width - 2) or [""]), *_missing(entry)]
        lines += [f"{names[name]:<{width}}  {first}", *(f"{'':<{width}}  {other}" for other in others)]
    return "\n".join(lines)


def _missing(entry: SearcherEntry) -> list[str]:
    if not entry.package or find_spec(entry.package) is not None:
        return []
    return ["not installed; to have it:", f"  {installing('search')}"]
