"""What of Scenic's own material is accepted here: `python -m benchmarks.scenic CHECKOUT [--programs] [--json]`

`CHECKOUT` is a checkout of Scenic's repository. Its driving scripts (`examples/driving`, `examples/carla`) are checked,
drawn and run once. Of `tests/syntax` every program is checked that stands as a literal text in the first argument of
one of the functions in `TAKERS`; one below `pytest.raises` is a program that Scenic refuses. Programs about space and
about Python modules are set aside, by `ASIDE`. Exit code 1 if anything crashes.
"""

import argparse
import ast
import inspect
import json
import re
import sys
import textwrap
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path

from cortex_dsl.api.scenario import compile_text, load
from cortex_dsl.diagnostics import CompileError, Severity
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source
from engine.config import Config
from engine.frozen import frozen

SCRIPTS = ("examples/driving", "examples/carla")
TAKERS = frozenset({
    "compileScenic", "sampleEgoFrom", "sampleSceneFrom", "sampleParamPFrom", "checkIfSamples",
    "sampleEgoActionsFromScene", "scenarioFromString", "runFile",
})  # fmt: skip
"""Functions of Scenic's tests that take a program as text."""
NO_PROGRAMS = frozenset(
    {"test_ast.py", "test_compiler.py", "test_parser.py", "test_highlighting.py", "test_internals.py"}
)
"""Tests of Scenic's own parser, tree and colours; they hold pieces, no programs."""
ASIDE = re.compile(
    r"\b(?:yaw|pitch|roll|Orientation|\w*Shape|Mesh\w*|BoxRegion|SpheroidRegion|PathRegion|Voxel\w*|PointSetRegion|"
    r"GridRegion|parentOrientation|contactTolerance|baseOffset|onSurface|onDirection|minTopZ|toHeading|altitude|"
    r"footprint|velocity|above|below|top|bottom)\b|\.z\b|"
    r"\([-\w. ]+,[-\w. ]+,[-\w. ]+\)|\bposition\.\w*3|^\s*(?:from|import)\s|\b(?:globals|locals|eval|exec|"
    r"async|await|yield|global|nonlocal|raise|with open|Exception|print|simulator)\b",
    re.MULTILINE,
)
"""What makes a program one about space, or about Python itself: these words, a triple, an import."""


@frozen
class Answer:
    """What became of one program."""

    name: str
    answer: str
    """`accepted`, `refused`, `no scene` or `crash`."""
    codes: tuple[str, ...] = ()
    line: int = 0
    said: str = ""
    refused_by_scenic: bool = False

    @property
    def agrees(self) -> bool:
        return (self.answer in ("refused", "no scene")) == self.refused_by_scenic


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--programs", action="store_true", help="list every program, not the counts alone")
    parser.add_argument("--only", choices=("scripts", "tests"), help="one half of the material")
    parser.add_argument("--check", action="store_true", help="do not run the scripts")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    scripts = (
        []
        if options.only == "tests"
        else [_script(options.checkout, each, options.check) for each in scripts_of(options.checkout)]
    )
    tests = [] if options.only == "scripts" else [_checked(*each) for each in programs_of(options.checkout)]
    if options.json:
        print(json.dumps({"scripts": [asdict(each) for each in scripts], "tests": [asdict(each) for each in tests]}))
    else:
        _print("Driving scripts", scripts, listed=True)
        _print("Programs of tests/syntax", tests, listed=options.programs)
    return 1 if any(each.answer == "crash" for each in (*scripts, *tests)) else 0


# -- the material -----------------------------------------------------------------------------------------------------


def scripts_of(checkout: Path) -> list[Path]:
    return sorted(path for folder in SCRIPTS for path in (checkout / folder).rglob("*.scenic"))


def programs_of(checkout: Path) -> Iterator[tuple[str, str, bool]]:
    """Name, text, and whether Scenic refuses it."""
    for path in sorted((checkout / "tests" / "syntax").glob("test_*.py")):
        if path.name in NO_PROGRAMS:
            continue
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(function, ast.FunctionDef) and function.name.startswith("test"):
                for number, (text, refused) in enumerate(_programs(function.body, refused=False)):
                    if not ASIDE.search(text):
                        yield f"{path.stem}.{function.name}[{number}]", text, refused


def _programs(body: Sequence[ast.AST], *, refused: bool) -> Iterator[tuple[str, bool]]:
    for node in body:
        if isinstance(node, ast.With):
            raises = any("raises" in ast.unparse(item.context_expr) for item in node.items)
            yield from _programs(node.body, refused=refused or raises)
            continue
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in TAKERS and node.args:
            first = node.args[0]
            if isinstance(first, ast.Constant) and isinstance(first.value, str):
                yield inspect.cleandoc(first.value) + "\n", refused
                continue
        yield from _programs(list(ast.iter_child_nodes(node)), refused=refused)


# -- what becomes of it ------------------------------------------------------------------------------------------------


def _script(checkout: Path, path: Path, check: bool) -> Answer:
    name = str(path.relative_to(checkout / "examples"))
    try:
        scenario = load(path, Config())
        if check:
            return Answer(name, "accepted")
        scenes = scenario.sample(1, seed=1)
        scenario.simulate(scenes)
        return Answer(name, "accepted" if scenes.valid[0] else "no scene")
    except Exception as error:
        return _failed(name, error, refused=False)


def _checked(name: str, text: str, refused: bool) -> Answer:
    """Scenic proves of some programs that they have no scene; here one is drawn."""
    try:
        compile_source(Source(f"{name}.scenic", text))
        drawn = not refused or compile_text(text).sample(1, seed=1).valid[0]
    except Exception as error:
        return _failed(name, error, refused=refused)
    return Answer(name, "accepted" if drawn else "no scene", refused_by_scenic=refused)


def _failed(name: str, error: Exception, *, refused: bool) -> Answer:
    if not isinstance(error, CompileError):
        return Answer(name, "crash", said=f"{type(error).__name__}: {error}", refused_by_scenic=refused)
    errors = [each for each in error.diagnostics if each.severity is Severity.ERROR]
    first = errors[0]
    line = error.source.row(first.label.span.start)
    codes = tuple(dict.fromkeys(each.code for each in errors))
    return Answer(name, "refused", codes, line, first.message, refused)


# -- what is printed ---------------------------------------------------------------------------------------------------


def _print(title: str, answers: Sequence[Answer], *, listed: bool) -> None:
    if not answers:
        return
    print(f"\n{title}: {len(answers)}\n")
    if listed:
        print("| program | answer | code | line | message |")
        print("|---|---|---|---|---|")
        for each in answers:
            said = textwrap.shorten(each.said, 90).replace("|", r"\|")
            answer = f"{each.answer}{'' if each.agrees else ', Scenic refuses' if each.refused_by_scenic else ''}"
            print(f"| {each.name} | {answer} | {' '.join(each.codes)} | {each.line or ''} | {said} |")
        print()
    for answer, count in Counter(each.answer for each in answers).most_common():
        print(f"{answer:>22} {count}")
    if any(each.refused_by_scenic for each in answers):
        here = sum(each.answer == "refused" and not each.refused_by_scenic for each in answers)
        there = sum(not each.agrees and each.refused_by_scenic for each in answers)
        both = sum(each.agrees and each.refused_by_scenic for each in answers)
        print(f"{'refused by both':>22} {both}")
        print(f"{'refused only here':>22} {here}\n{'refused only by Scenic':>22} {there}")
    codes = Counter(each.codes[0] for each in answers if each.codes and not each.refused_by_scenic)
    print(f"{'first code':>22} {', '.join(f'{code} {count}' for code, count in codes.most_common())}")


if __name__ == "__main__":
    sys.exit(main())
