"""Is there an export that breaks `cortexc import`, or takes too long? OpenSCENARIO files and their roads, changed.

    python -m benchmarks.fuzz exports [--count 2000] [--seed 0] [--keep FOLDER] [--json]

Cases of the examples are exported in every version and mode. One file of each has one to four changes: an element or
attribute is deleted, doubled or moved, a number becomes 0, changes its sign or jumps, a value becomes that of another
attribute or no number; or pieces of the text are changed as in a recording. `cortexc import` judges it, or writes it in
other formats, too. It must end in a result whose JSON is strict, or in a refusal that names the file and a cure, within
the time limit. Exit code 1 if one does not; `--keep` writes those files down, and the slowest.
"""

import random
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from benchmarks.fuzz.files import Fuzzer, Judge, Sample, run
from benchmarks.fuzz.maps import CHANGES
from benchmarks.fuzz.recordings import TEXTS, changed, judge
from cortex_dsl import export, load
from engine.interchange import ExportOptions
from engine.interchange.opendrive import write_opendrive
from engine.interchange.openscenario import write_trajectories
from tests.engine.interchange.openscenario.conftest import ROAD, small, with_lights

EXAMPLES = Path(__file__).parents[2] / "examples"
EXPORTED: Sequence[tuple[str, Mapping[str, Any]]] = (
    ("left_turn.scn", {"osc": "1.0"}),
    ("left_turn.scn", {"mode": "maneuver"}),
    ("roads/village.scn", {"osc": "1.1"}),
    ("roads/on_ramp.scn", {"osc": "1.3"}),
)
FORMATS = ("xosc", "csv", "mcap", "scn", "xosc,csv,scn")


@cache
def sound() -> tuple[Sample, ...]:
    """Return exports to change: short ones made by hand, and those of examples."""
    made = [
        {
            **write_trajectories(recording, "case", ExportOptions(), ROAD).files,
            ROAD: write_opendrive(recording.road, recording.signals, "road"),
        }
        for recording in (small(), with_lights())
        if recording.road is not None
    ]
    with tempfile.TemporaryDirectory() as folder:
        for number, (file, options) in enumerate(EXPORTED):
            out = Path(folder) / str(number)
            paths = export(load(EXAMPLES / file), "xosc", out, **options)
            made.append({path.name: path.read_bytes() for path in paths})
    return tuple(Sample({name: _bytes(content) for name, content in files.items()}) for files in made)


def _bytes(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


def reword(rng: random.Random, root: Element) -> None:
    """Give an attribute the value of another one, or a text that is no number."""
    elements = [element for element in root.iter() if element.attrib]
    if elements:
        element, other = rng.choice(elements), rng.choice(elements)
        words = TEXTS if rng.random() < 0.5 else (*other.attrib.values(), f"${next(iter(other.attrib))}")
        element.set(rng.choice(sorted(element.attrib)), rng.choice(words))


def changed_elements(rng: random.Random, content: bytes) -> bytes:
    """An XML file with other elements and attributes."""
    root = deepcopy(_parsed(content))
    for _ in range(rng.choice((1, 1, 2, 4))):
        pairs = [(parent, element) for parent in root.iter() for element in parent]
        if pairs and rng.random() < 0.8:
            rng.choice(CHANGES)(rng, *rng.choice(pairs))
        else:
            reword(rng, root)
    return ElementTree.tostring(root, encoding="utf-8")


@cache
def _parsed(content: bytes) -> Element:
    return ElementTree.fromstring(content)


def samples(rng: random.Random) -> Iterator[Sample]:
    """Yield changed exports for ever, one case after the other."""
    while True:
        for sample in sound():
            which = rng.choice((sample.name, sample.name, sample.name, *sample.files))
            old = sample.files[which]
            new = changed(rng, which, old) if rng.random() < 0.2 else changed_elements(rng, old)
            yield Sample({**sample.files, which: new})


@contextmanager
def judging(rng: random.Random) -> Iterator[Judge]:
    """Yield a function that judges an export: its ego, or now and then its copies in other formats, too."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)

        def judged(sample: Sample) -> str:
            to = ("--to", rng.choice(FORMATS), "--out", str(folder / "copies")) if rng.random() < 0.3 else ()
            return judge(sample, folder, "import", *to)

        judge(sound()[0], folder, "import", "--to", FORMATS[-1], "--out", str(folder / "copies"))
        yield judged


FUZZER = Fuzzer(samples, judging)


def main(arguments: Sequence[str]) -> int:
    return run(__doc__, FUZZER, arguments)
