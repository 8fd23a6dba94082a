"""Declared diagnostics: every use fills in every field of its templates."""

import ast
import re
import string
from pathlib import Path

import pytest

import cortex_dsl
from cortex_dsl.semantics.errors import declared
from cortex_dsl.semantics.errors.problems import Problem

HOME = Path(cortex_dsl.__file__).parent
MODULES = sorted(path for folder in ("semantics", "api", "console") for path in (HOME / folder).rglob("*.py"))
PROBLEMS = declared()


def fields_of(problem: Problem) -> set[str]:
    """Names in braces in the texts of a problem."""
    texts = problem.message + problem.reason + problem.cure
    return {name for _, name, _, _ in string.Formatter().parse(texts) if name}


def uses(path: Path) -> list[tuple[str, set[str], int]]:
    """Each `NAME.at(...)` or `.mistake(...)` of a module: name, fields given, line."""
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
            continue
        if node.func.attr in ("at", "mistake") and isinstance(node.func.value, ast.Name):
            given = {keyword.arg for keyword in node.keywords if keyword.arg}
            found.append((node.func.value.id, given, node.lineno))
    return [use for use in found if use[0] in PROBLEMS]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_every_use_fills_every_field(path: Path) -> None:
    """A missing field would be a crash at the worst moment."""
    for name, given, line in uses(path):
        assert fields_of(PROBLEMS[name]) <= given, f"{path.name}:{line}: {name}"


def test_every_problem_is_used() -> None:
    """No diagnostic that nothing says."""
    texts = [path.read_text() for path in MODULES if path.parent.name != "errors"]
    named = {name for text in texts for name in re.findall(r"\w+", text)}
    assert set(PROBLEMS) <= named
