"""Is there a road file that breaks a command, or takes too long? Elements and attributes of OpenDRIVE files, changed.

    python -m benchmarks.fuzz maps [--count 2000] [--seed 0] [--keep FOLDER] [--json]

Each file has one to four changes: an element or attribute is deleted or doubled, a number becomes 0, changes its sign,
or jumps. A scenario on its roads is compiled, and cars are placed and driven for a second. It must end in a run, in a
run and a note, or in a refusal that says where in the file, within the time limit. Exit code 1 if one does not;
`--keep` writes those files down, and the slowest.
"""

import argparse
import json
import random
import re
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from unittest.mock import patch
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from benchmarks.fuzz.texts import limited
from cortex_dsl import CompileError, compile_text
from cortex_dsl.diagnostics import Severity
from engine.interchange.opendrive import write_opendrive
from engine.maps import LoneRoad, MapFile, MapSpec, RoadSpec, Roundabout
from engine.road.opendrive import network

EXAMPLES = Path(__file__).parents[2] / "examples" / "roads"
TIME_LIMIT = 10
"""For one file [s]."""
SPECS: tuple[MapSpec, ...] = (LoneRoad(2, 150.0, -60.0), Roundabout(3, 1, 30.0), RoadSpec())
JUMPS = (1e-9, 1e-3, 0.1, 0.9, 1.1, 10.0, 1e3, 1e6, 1e12)
PLACE = re.compile(r"line \d+|\.xodr")
SCENARIO = """map opendrive("{}")
ego = new Car on road, with behavior FollowLaneBehavior(10 m/s)
other = new Car on road, with behavior FollowLaneBehavior(10 m/s)
terminate after 1 s
"""
Change = Callable[[random.Random, Element, Element], None]


# -- files -------------------------------------------------------------------------------------------------------------


@cache
def sound() -> tuple[Element, ...]:
    """Return files to change: the examples, and roads of our own as they are exported."""
    texts = [path.read_text(encoding="utf-8") for path in sorted(EXAMPLES.glob("*.xodr"))]
    texts += [write_opendrive(spec, None, "road") for spec in SPECS]
    return tuple(ElementTree.fromstring(text) for text in texts)


def delete(rng: random.Random, parent: Element, element: Element) -> None:
    """Take out an element, or one of its attributes."""
    if element.attrib and rng.random() < 0.5:
        del element.attrib[rng.choice(sorted(element.attrib))]
    else:
        parent.remove(element)


def double(_: random.Random, parent: Element, element: Element) -> None:
    """Write an element twice."""
    parent.insert(list(parent).index(element), deepcopy(element))


def move(rng: random.Random, parent: Element, element: Element) -> None:
    """Put an element elsewhere among those beside it."""
    parent.remove(element)
    parent.insert(rng.randrange(len(parent) + 1), element)


def zero(rng: random.Random, _: Element, element: Element) -> None:
    _number(rng, element, lambda _: 0.0)


def sign(rng: random.Random, _: Element, element: Element) -> None:
    _number(rng, element, lambda value: -value)


def jump(rng: random.Random, _: Element, element: Element) -> None:
    """Multiply a number by something large or small, or add something."""
    if rng.random() < 0.5:
        _number(rng, element, lambda value: value * rng.choice(JUMPS))
    else:
        _number(rng, element, lambda value: value + rng.choice((-1.0, 1.0)) * rng.choice(JUMPS))


def _number(rng: random.Random, element: Element, change: Callable[[float], float]) -> None:
    """Change one of the numbers of an element; whole ones stay whole, as ids are."""
    numbers = [name for name, text in sorted(element.items()) if re.fullmatch(r"-?\d+(\.\d*)?(e-?\d+)?", text)]
    if numbers:
        name = rng.choice(numbers)
        text = element.attrib[name]
        value = change(float(text))
        element.set(name, str(int(value)) if re.fullmatch(r"-?\d+", text) and abs(value) < 1e9 else repr(value))


CHANGES: tuple[Change, ...] = (delete, double, move, zero, sign, jump, jump)


def files(rng: random.Random) -> Iterator[str]:
    """Yield changed files for ever."""
    while True:
        root = deepcopy(rng.choice(sound()))
        for _ in range(rng.choice((1, 1, 2, 4))):
            pairs = [(parent, element) for parent in root.iter() for element in parent]
            if pairs:
                rng.choice(CHANGES)(rng, *rng.choice(pairs))
        yield ElementTree.tostring(root, encoding="unicode")


# -- judgement ---------------------------------------------------------------------------------------------------------


@contextmanager
def judging() -> Iterator[Callable[[str], str]]:
    """Yield a function that judges the text of a file; it writes nothing to the user's cache."""
    with tempfile.TemporaryDirectory() as folder, patch.object(network, "cached_file", lambda *_: None):
        yield lambda text: judge(text, Path(folder) / "map.xodr")


def judge(text: str, path: Path) -> str:
    """Return `run`, `run with a note` or `refused`; raise whatever must not be."""
    path.write_text(text, encoding="utf-8")
    try:
        scenario = compile_text(SCENARIO.format(path))
    except CompileError as error:
        wrong = [each for each in error.diagnostics if each.severity is Severity.ERROR]
        if not wrong:
            raise AssertionError("an error without a diagnostic") from error
        for each in wrong:
            if each.code == "SCN439" and not (PLACE.search(each.message.partition("cannot be read")[2]) and each.cure):
                raise AssertionError(f"a refusal without a place or cure: {each.message}") from error
        return "refused"
    scenes = scenario.sample(3, seed=1)
    scenario.simulate(scenes)
    spec = scenario.program.road_spec
    assert isinstance(spec, MapFile)
    return "run with a note" if network.file_network(spec).remarks else "run"


@dataclass(frozen=True)
class Judged:
    """What became of all files."""

    count: int
    outcomes: dict[str, int]
    broken: int
    slowest: float
    """[s]"""
    seconds: float


def fuzz(count: int, seed: int = 0, keep: Path | None = None) -> Judged:
    """Judge that many files; those that break something are written to `keep`."""
    begin, stream = time.perf_counter(), files(random.Random(seed))
    outcomes, slowest, slowest_text = Counter[str](), 0.0, ""
    with judging() as judged:
        judged(ElementTree.tostring(sound()[0], encoding="unicode"))  # kernels are loaded
        for number in range(count):
            text, start = next(stream), time.thread_time()
            try:
                with limited(TIME_LIMIT):
                    outcome = judged(text)
            except KeyboardInterrupt:
                raise
            except BaseException as error:
                outcome = "broken"
                _write(keep, f"{number:05d}-{type(error).__name__}", text, traceback.format_exc())
            slowest, slowest_text = max((slowest, slowest_text), (time.thread_time() - start, text))
            outcomes[outcome] += 1
    _write(keep, "slowest", slowest_text, f"{slowest:.2f} s")
    found = dict(sorted(outcomes.items()))
    return Judged(count, found, outcomes["broken"], slowest, time.perf_counter() - begin)


def _write(folder: Path | None, name: str, text: str, told: str) -> None:
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.xodr").write_text(text, encoding="utf-8")
        (folder / f"{name}.txt").write_text(told, encoding="utf-8")


def main(arguments: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args(arguments)
    found = fuzz(options.count, options.seed, options.keep)
    if options.json:
        print(json.dumps(asdict(found), indent=2))
    else:
        for name, count in found.outcomes.items():
            print(f"{name:22}{count:>9,}")
        print(f"broken {found.broken}, slowest {found.slowest:.2f} s, {found.seconds:.0f} s in all")
    return 1 if found.broken else 0
