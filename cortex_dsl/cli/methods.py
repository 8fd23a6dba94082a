"""The names behind `--method`, and `cortexc --method list`: every way to search, in one line each."""

from importlib.util import find_spec

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.spelling import nearest
from engine.search.searchers import SearcherEntry, UnknownMethod, canonical, known_searchers


def named(text: str) -> tuple[str, ...]:
    """The methods of a list with commas.

    Raises:
        UsageError: one of them is not known.
    """
    try:
        return tuple(canonical(word) for word in text.split(","))
    except UnknownMethod as error:
        names = [name for method, entry in known_searchers().items() for name in (method, entry.alias) if name]
        near = nearest(error.name, names)
        cure = f"did you mean `{near}`?" if near else "`cortexc --method list` tells them all"
        raise UsageError(f"--method: there is no method `{error.name.strip()}`", cure) from None


def method_list() -> str:
    """A table of names, short names and what they do; what is not installed says so."""
    entries = known_searchers()
    names = {name: f"{name} ({entry.alias})" if entry.alias else name for name, entry in entries.items()}
    width = max(map(len, names.values()))
    return "\n".join(f"{names[name]:<{width}}  {entry.summary}{_missing(entry)}" for name, entry in entries.items())


def _missing(entry: SearcherEntry) -> str:
    if not entry.package or find_spec(entry.package) is not None:
        return ""
    return "  [not installed: pip install 'cortexc[search]']"
