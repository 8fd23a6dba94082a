"""Find the files that the repository keeps beside the packages and a wheel inside this one: grammar and examples."""

from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path


def resource(name: str) -> Traversable:
    """Return the file or folder that the repository calls `name`, such as `grammar/cortex.lark`.

    A wheel carries it in `cortex_dsl/data` (pyproject.toml says which). A clone and an editable install have no such
    folder: there the packages lie in the repository itself.
    """
    shipped = files("cortex_dsl") / "data"
    return (shipped if shipped.is_dir() else Path(__file__).parents[1]).joinpath(*name.split("/"))
