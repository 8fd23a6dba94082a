"""Are our exports right in the eyes of others? `make validate`, or `python -m benchmarks.validation`.

Sets up the checkers of the standards and of other tools, each in an environment of its own (a network, once, about a
minute), searches A to F for their worst cases, writes those in every format and version, beside scenes without contact,
a sweep over every kind of road and scenarios of every construct, and asks the checkers. Exit code 1 with any finding.
"""

import argparse
import os
import sys
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from benchmarks.validation.checks import CHECKS, Verdict, judged
from benchmarks.validation.drives import drives
from benchmarks.validation.encounters import encounters
from benchmarks.validation.environments import FOLDER, ROOT, SetupError, set_up
from benchmarks.validation.items import Item
from benchmarks.validation.looks import looked
from benchmarks.validation.material import CONSTRUCTS, EXAMPLES, cases, written
from benchmarks.validation.roads import swept
from benchmarks.validation.samples import sampled
from benchmarks.validation.table import markdown, show, write

LACKING = {"scenario_runner": "SCENARIO_RUNNER_ROOT"}
"""What no package index has, and the variable that names its folder."""
PAGE = ROOT / "docs" / "how-to" / "cases-elsewhere.md"


def main() -> int:
    """Set up, write, check, and print the result."""
    arguments = _arguments()
    console = Console(highlight=False)
    checks = [check for check in CHECKS if not arguments.only or check.checker in arguments.only]
    for check in [check for check in checks if (lacks := LACKING.get(check.checker)) and lacks not in os.environ]:
        console.print(f"[yellow]left out[/]: {check.title}, whose folder {LACKING[check.checker]} names")
        checks.remove(check)
    try:
        set_up(dict.fromkeys(check.checker for check in checks if check.checker), arguments.python, console.print)
    except SetupError as problem:
        console.print(f"[red]error[/]: {problem}")
        return 2
    items = list(_items(arguments, console, {kind for check in checks for kind in check.kinds}))
    verdicts: list[Verdict] = []
    for check in checks:
        console.print(f"asking {check.title}", style="dim")
        verdicts += judged(check, items)
    show(verdicts, console)
    if arguments.write:
        write(PAGE, markdown(verdicts))
    return 1 if any(verdict.findings for verdict in verdicts) else 0


def _items(arguments: argparse.Namespace, console: Console, asked: set[str]) -> Iterator[Item]:
    folder: Path = arguments.out
    yield from encounters(folder / "encounters")
    if asked == {"encounter"}:
        return
    if "looks" in asked:
        console.print("looking past one another", style="dim")
        yield from looked(folder / "looks", arguments.looks)
    if "samples" in asked:
        console.print("sampling scripts of Scenic", style="dim")
        yield from sampled(folder / "samples")
    if not arguments.cases_only:
        console.print("writing every kind of road", style="dim")
        yield from swept(folder / "roads")
        console.print("driving on every kind of road", style="dim")
        for case, kinds in drives():
            yield from written([case], folder / "drives", asked.intersection(kinds))
    for file in EXAMPLES if arguments.examples_only else [*EXAMPLES, *CONSTRUCTS]:
        console.print(f"searching and writing {file.stem}", style="dim")
        top = arguments.top if file in EXAMPLES else 3
        found = cases(file, folder / "runs" / file.stem, top, arguments.others)
        yield from written(found, folder / file.stem, asked)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.validation", description=__doc__.partition("\n\n")[0])
    parser.add_argument("--top", type=int, default=10, help="worst cases of each of A to F")
    parser.add_argument("--others", type=int, default=3, help="scenes without contact of each scenario")
    parser.add_argument("--looks", type=int, default=2000, help="scenes for Scenic's `can see`")
    parser.add_argument("--only", nargs="+", help="these checkers alone")
    parser.add_argument("--cases-only", action="store_true", help="without the sweep over roads")
    parser.add_argument("--examples-only", action="store_true", help="without the scenarios of every construct")
    parser.add_argument("--python", default=sys.executable, help="what the environments are made with")
    parser.add_argument("--out", type=Path, default=FOLDER / "files", help="where the files go that are checked")
    parser.add_argument("--write", action="store_true", help="put the table into docs/how-to/cases-elsewhere.md")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
