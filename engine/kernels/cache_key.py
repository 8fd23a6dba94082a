"""The sources that a compiled kernel depends on, and their digest. Needs the standard library alone."""

import ast
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import cast

KERNELS = Path(__file__).parent
KERNEL_INPUTS = (
    "handles.py",
    "named_results.py",
    "opcodes.py",
    "operators/__init__.py",
    "outcomes.py",
    "result_row.py",
    "tables.py",
    "vocabulary.py",
)
"""Modules of `engine` that kernels read: names, columns and enum values are constants of the machine code."""


def text_digest(kernels: Path = KERNELS) -> str:
    """Return the digest of all bytes of the sources; it costs 2 ms, `syntax_digest` 0.3 s."""
    return _digest((name, path.read_bytes()) for name, path in _sources(kernels))


def syntax_digest(kernels: Path = KERNELS) -> str:
    """Return the digest of the sources' meaning: no comment, docstring, line number or layout changes it."""
    trees = ((name, _described(ast.parse(path.read_bytes()))) for name, path in _sources(kernels))
    return _digest((name, repr(tree).encode()) for name, tree in trees)


def _sources(kernels: Path) -> Iterator[tuple[str, Path]]:
    for path in (*sorted(kernels.rglob("*.py")), *(kernels.parent / name for name in KERNEL_INPUTS)):
        yield path.relative_to(kernels.parent).as_posix(), path


def _digest(parts: Iterable[tuple[str, bytes]]) -> str:
    digest = hashlib.sha256()
    for name, content in parts:
        digest.update(f"{name} {hashlib.sha256(content).hexdigest()}\n".encode())
    return digest.hexdigest()[:16]


def _described(value: object) -> object:
    """Return a syntax tree as tuples. Empty fields are left out, so that all versions of Python give the same.

    A statement that consists of a string, such as a docstring, has no effect and is left out too.
    """
    match value:
        case ast.AST():
            fields = ((name, each) for name, each in ast.iter_fields(value) if each is not None and each != [])
            return (type(value).__name__, *((name, _described(each)) for name, each in fields))
        case list():
            return tuple(_described(each) for each in cast("list[object]", value) if not _is_note(each))
        case _:
            return value


def _is_note(value: object) -> bool:
    return isinstance(value, ast.Expr) and isinstance(value.value, ast.Constant) and isinstance(value.value.value, str)
