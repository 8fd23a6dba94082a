"""Is there a road file that breaks a command, or takes too long? Elements and attributes of OpenDRIVE files, changed.

    python -m benchmarks.fuzz maps [--count 2000] [--seed 0] [--keep FOLDER] [--json]

Each file has one to four changes: an element or attribute is deleted or doubled, a number becomes 0, changes its sign,
or jumps. A scenario on its roads is compiled, and cars are placed and driven for a second. It must end in a run, in a
run and a note, or in a refusal that says where in the file, within the time limit. Exit code 1 if one does not;
`--keep` writes those files down, and the slowest.
"""

import random
import re
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import cache
from pathlib import Path
from unittest.mock import patch
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from benchmarks.fuzz.files import JUMPS, Fuzzer, Judge, Sample, run
from cortex_dsl import CompileError, compile_text
from cortex_dsl.diagnostics import Severity
from engine.interchange.opendrive import write_opendrive
from engine.maps import LoneRoad, MapFile, MapSpec, RoadSpec, Roundabout
from engine.road.opendrive import network

EXAMPLES = Path(__file__).parents[2] / "examples" / "roads"
SPECS: tuple[MapSpec, ...] = (LoneRoad(2, 150.0, -60.0), Roundabout(3, 1, 30.0), RoadSpec())
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


def samples(rng: random.Random) -> Iterator[Sample]:
    """Yield changed files for ever."""
    while True:
        root = deepcopy(rng.choice(sound()))
        for _ in range(rng.choice((1, 1, 2, 4))):
            pairs = [(parent, element) for parent in root.iter() for element in parent]
            if pairs:
                rng.choice(CHANGES)(rng, *rng.choice(pairs))
        yield _sample(root)


def _sample(root: Element) -> Sample:
    return Sample({"map.xodr": ElementTree.tostring(root, encoding="utf-8")})


# -- judgement ---------------------------------------------------------------------------------------------------------


@contextmanager
def judging(_: random.Random) -> Iterator[Judge]:
    """Yield a function that judges a file; it writes nothing to the user's cache."""
    with tempfile.TemporaryDirectory() as folder, patch.object(network, "cached_file", lambda *_: None):
        judge(_sample(sound()[0]), Path(folder))
        yield lambda sample: judge(sample, Path(folder))


def judge(sample: Sample, folder: Path) -> str:
    """Return `run`, `run with a note` or `refused`; raise whatever must not be."""
    path = folder / sample.name
    path.write_bytes(sample.files[sample.name])
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


FUZZER = Fuzzer(samples, judging)


def main(arguments: Sequence[str]) -> int:
    return run(__doc__, FUZZER, arguments)
