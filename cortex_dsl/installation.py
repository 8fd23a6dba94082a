"""The installation: the files that ship with it, and whether it is whole.

`engine` is a common name, and another package of that name may hide ours. Nothing of the engine can be imported then,
its exceptions included; they are read from their file.
"""

import sys
from functools import lru_cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from importlib.resources import files
from importlib.resources.abc import Traversable
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType

HOME = Path(__file__).resolve().parent.parent
"""The folder in which our two packages lie side by side."""
ENGINE = "engine"
ERRORS = f"{ENGINE}.errors"
REPORTING = (ERRORS, f"{ENGINE}.strict_json")
"""Modules by which a command reports that another package hides ours."""


def check_engine() -> None:
    """Raises HiddenEngineError, which is a CortexError, where `import engine` would find another package than ours."""
    found = _other_engine()
    if found is not None:
        raise errors().HiddenEngineError(HOME / ENGINE, found)


def errors() -> ModuleType:
    """The module `engine.errors`, ours even where another `engine` hides it."""
    return import_module(ERRORS) if _other_engine() is None else _read_from_file(ERRORS)


def provide_errors() -> None:
    """Make `from engine.errors import …` succeed in any case, so that a command can report the problem."""
    if _other_engine() is not None:
        for name in REPORTING:
            sys.modules.setdefault(name, _read_from_file(name))


@lru_cache(maxsize=len(REPORTING))
def _read_from_file(name: str) -> ModuleType:
    spec = spec_from_file_location(name, HOME.joinpath(*name.split(".")).with_suffix(".py"))
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _other_engine() -> str | None:
    """Return the place of a foreign `engine` package, or `nowhere`; None if the package is ours."""
    spec = _engine_spec()
    places = [] if spec is None else [Path(place).resolve() for place in spec.submodule_search_locations or ()]
    if HOME / ENGINE in places:
        return None
    if spec is not None and not places and spec.origin:
        places = [Path(spec.origin).resolve()]
    return f"at {places[0]}" if places else "nowhere"


def _engine_spec() -> ModuleSpec | None:
    try:
        return find_spec(ENGINE)
    except ValueError:  # a module without a spec, made by hand
        return None


# -- files that a clone has next to the packages, and a wheel inside this one: grammar and examples --------------------


def resource(name: str) -> Traversable:
    """Return the file or folder that the repository calls `name`, such as `grammar/cortex.lark`.

    A wheel carries it in `cortex_dsl/data` (pyproject.toml says which). A clone and an editable install have no such
    folder: there the packages lie in the repository itself.
    """
    shipped = files("cortex_dsl") / "data"
    return (shipped if shipped.is_dir() else Path(__file__).parents[1]).joinpath(*name.split("/"))
