"""Which small changes of the code the tests notice: `python -m benchmarks.mutants DATA [COUNT] [--profile NAME]`.

DATA is what `pytest --cov --cov-context=test --cov-report=` left: it says which tests execute a line. Of all places in
`engine` (but its kernels) and `cortex_dsl`, by path, line and column, COUNT are drawn. Each is changed in a
throwaway copy of the checkout, in which the tests that execute its line run until one of them fails.
"""

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from coverage import CoverageData

ROOT = Path(__file__).parents[1]
SEED, COUNT, PATIENCE = 20261128, 30, 600.0
OTHERS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
NOT_COPIED = shutil.ignore_patterns(".git", ".venv", "build", "__pycache__", ".hypothesis")


@dataclass(frozen=True, order=True)
class Site:
    """A place in a file and what stands there instead, as offsets of its text in UTF-8."""

    path: str
    line: int
    column: int
    start: int
    end: int
    before: str
    after: str

    def mutated(self, text: bytes) -> bytes:
        return text[: self.start] + self.after.encode() + text[self.end :]


def changes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the mutants of one node."""
    match node:
        case ast.Compare(left=left, ops=[first, *rest], comparators=comparators):
            yield ast.Compare(left, [OTHERS[type(first)](), *rest], comparators)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            yield ast.BinOp(left, ast.Sub(), right)
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            yield ast.BinOp(left, ast.Add(), right)
        case ast.BoolOp(op=ast.And(), values=values):
            yield ast.BoolOp(ast.Or(), values)
        case ast.BoolOp(op=ast.Or(), values=values):
            yield ast.BoolOp(ast.And(), values)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            yield operand
        case ast.Constant(value=int(value)) if not isinstance(value, bool):
            yield ast.Constant(value + 1)
        case ast.Return(value=ast.expr()):
            yield ast.Return(ast.Constant(None))


def nodes(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what stands in a tree, but for f-strings, whose parts have no places of their own in Python 3.11."""
    if not isinstance(tree, ast.JoinedStr):
        yield tree
        for child in ast.iter_child_nodes(tree):
            yield from nodes(child)


def sites(root: Path) -> list[Site]:
    """Return all places that can be changed, in the order of path, line and column."""
    found = []
    for path in sorted([*root.glob("engine/**/*.py"), *root.glob("cortex_dsl/**/*.py")]):
        name, text = path.relative_to(root).as_posix(), path.read_bytes()
        if name.startswith("engine/kernels/"):
            continue
        starts = [0]
        for line in text.splitlines(keepends=True):
            starts.append(starts[-1] + len(line))
        for node in nodes(ast.parse(text)):
            for mutant in changes(node):
                assert isinstance(node, ast.expr | ast.stmt)
                assert node.end_lineno is not None
                assert node.end_col_offset is not None
                start = starts[node.lineno - 1] + node.col_offset
                end = starts[node.end_lineno - 1] + node.end_col_offset
                after = ast.unparse(ast.fix_missing_locations(mutant))
                after = after if isinstance(node, ast.Return) else f"({after})"
                found.append(Site(name, node.lineno, node.col_offset, start, end, text[start:end].decode(), after))
    return sorted(found)


def tests_of(site: Site, data: CoverageData) -> list[str]:
    """Return the tests that execute a line; of a line that runs when its file is imported, those that use the file."""
    (file,) = [name for name in data.measured_files() if name.endswith(f"/{site.path}")]
    by_line = data.contexts_by_lineno(file)
    here = {context for context in by_line.get(site.line, []) if context}
    found = here or {context for contexts in by_line.values() for context in contexts if context}
    return sorted({context.rpartition("|")[0] for context in found})


def verdict(site: Site, tests: list[str], profile: str) -> str:
    """Return the test that fails where a site is changed, or that none does."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "copy"
        shutil.copytree(ROOT, copy, ignore=NOT_COPIED)
        path = copy / site.path
        path.write_bytes(site.mutated(path.read_bytes()))
        (copy / "names").write_text("\n".join(tests), encoding="utf-8")
        options = ["-x", "-q", "-p", "no:cacheprovider", "--hypothesis-profile", profile]
        command = [sys.executable, "-m", "pytest", *options, "@names"]
        environment = os.environ | {"PYTHONPATH": str(copy)}
        try:
            done = subprocess.run(
                command, cwd=copy, env=environment, capture_output=True, text=True, timeout=PATIENCE, check=False
            )
        except subprocess.TimeoutExpired:
            return "survived (out of time)"
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    return f"killed by {failed[1]}" if failed else "survived" if done.returncode == 0 else "killed: no test begins"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path)
    parser.add_argument("count", type=int, nargs="?", default=COUNT)
    parser.add_argument("--profile", default="push")
    parser.add_argument("--only", type=int, nargs="*", help="numbers of rows")
    asked = parser.parse_args()
    data = CoverageData(str(asked.data))
    data.read()
    for number, site in enumerate(random.Random(SEED).sample(sites(ROOT), asked.count), 1):
        if not asked.only or number in asked.only:
            tests = tests_of(site, data)
            found = verdict(site, tests, asked.profile) if tests else "survived: no test"
            change = f"`{' '.join(site.before.split())[:60]}` -> `{site.after[:60]}`".replace("|", "\\|")
            print(f"| {number} | {site.path} | {site.line} | {change} | {len(tests)} tests: {found} |", flush=True)


if __name__ == "__main__":
    main()
