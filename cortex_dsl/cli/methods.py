"""`cortexc --method list`: every way to search, in one line each."""

from importlib.util import find_spec

from engine.search.searchers import SearcherEntry, known_searchers


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
