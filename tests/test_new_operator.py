"""A new operator is an instruction, a scalar function and one row: every pass then has it.

A copy of the product gets them, as a maintainer would write them, and runs without the compiler of kernels in processes
of its own.
"""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.fork_server import RUN, Ended, ForkServer

ROOT = Path(__file__).parent.parent
ROW = """    Op.SIGN: Operator(
        scalars.sign, intervals.exactly_rising(np.sign),
        lambda z, a: [(np.where(z.low > 0.0, 0.0, -np.inf), np.where(z.high < 0.0, 0.0, np.inf))],
        lambda a: (scalars.sign(a[0]), scalars.sign(a[1])),
        Function("sign", "Sign of a pure number: -1, 0 or 1.", Rule.PURE), is_exact=True,
    ),
"""
SCALAR = '''def sign(x: float) -> float:
    """Return -1, 0 or 1."""
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else x


'''
BEFORE = {
    "engine/opcodes.py": {"\n    # -- geometry: packed": "    SIGN = 38\n"},
    "engine/kernels/scalars.py": {"def hypot(": SCALAR},
    "engine/operators/__init__.py": {"    Op.SIN: ": ROW},
}
"""The lines that a maintainer writes, by the place that they stand before."""
LOADED = """
import sys
from cortex_dsl.__main__ import process
from cortex_dsl.api import scenario
from cortex_dsl.cli import main
from engine import batch, world
from engine.interchange.openscenario import maneuvers
"""
HOSTS = """
import sys
from pathlib import Path
from cortex_dsl.api.scenario import load
scenario = load(Path(sys.argv[1]))
scenes = scenario.sample(8, seed=1)
print(sorted(set(scenes.values[:, 0].tolist())))
print(scenario.simulate(scenes).end_time.round(3).tolist())
print(scenario.simulate(scenes, "world").end_time.round(3).tolist())
"""
PLACE = "ego = new Car at ({x}, -1.75), facing 0 deg, with speed {speed}\n"
SCENARIO = "param X = Range(-4, 4)\n" + PLACE


class Product:
    """A copy of the product that has the operator."""

    server: ForkServer

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in ("cortex_dsl", "engine", "grammar"):
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name, edits in BEFORE.items():
            path = folder / name
            source = path.read_text(encoding="utf-8")
            for place, lines in edits.items():
                assert source.count(place) == 1, place
                source = source.replace(place, lines + place)
            path.write_text(source, encoding="utf-8")

    def ask(self, scenario: str, *words: str, code: str = RUN) -> Ended:
        """Run a command on a scenario, in a process that knows the product."""
        (self.folder / "case.scn").write_text(scenario, encoding="utf-8")
        return self.server.run(code, *words, at=self.folder)

    def says(self, scenario: str, *words: str, code: str = RUN) -> str:
        """Return what a command prints that succeeds."""
        ended = self.ask(scenario, *words, code=code)
        assert ended.status == 0, ended.err
        return ended.out


@pytest.fixture(scope="module")
def product(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Product]:
    product = Product(tmp_path_factory.mktemp("product"))
    environment = {
        **os.environ,
        "PYTHONPATH": str(product.folder),
        "CORTEXC_CACHE": str(product.folder / "cache"),
        "NUMBA_DISABLE_JIT": "1",
        "COLUMNS": "100",
    }
    with ForkServer(LOADED, tmp_path_factory.mktemp("server"), environment=environment) as product.server:
        yield product


def test_constants_are_folded_and_the_listing_prints_the_rest(product: Product) -> None:
    """The sign of -3 is a literal, that of a param is an instruction of one operand."""
    folded = product.says(SCENARIO.format(x="sign(-3)", speed="8 m/s"), "case.scn", "--emit", "program")
    assert "sign" not in folded
    listed = product.says(SCENARIO.format(x="sign(X)", speed="8 m/s"), "case.scn", "--emit", "program")
    assert "<- sign             g0\n" in listed


def test_its_rule_decides_on_dimensions(product: Product) -> None:
    """A pure number has a sign, a length has none here."""
    ended = product.ask(SCENARIO.format(x="sign(3 m)", speed="8 m/s"), "case.scn", "--check")
    assert ended.status == 1
    assert "the argument of `sign`" in ended.err + ended.out


def test_proofs_know_its_interval_both_ways(product: Product) -> None:
    """A sign never exceeds 1; one that must be positive cuts the param to numbers that are not negative."""
    never = product.ask(SCENARIO.format(x="X", speed="8 m/s") + "require sign(X) > 1.5\n", "case.scn", "--check")
    assert never.status == 1
    cut = product.says(SCENARIO.format(x="X", speed="8 m/s") + "require sign(X) > 0.5\n", "case.scn", "--check")
    assert "X below 0.000  cannot hold" in cut


def test_sampler_and_hosts_compute_it(product: Product) -> None:
    """At the start, where it decides on the place of the ego; and in each sample, where it ends the run at step 21."""
    ending = "terminate when sign(simulation().currentTime - 20) > 0.5\n"
    text = SCENARIO.format(x="10 * sign(X)", speed="8 m/s") + ending
    places, batch, world = product.says(text, "case.scn", code=HOSTS).splitlines()
    assert places == "[-10.0, 10.0]"
    assert batch == world == str([1.05] * 8)


def test_exports_say_that_they_cannot_write_it(product: Product) -> None:
    """A row without a name in OpenSCENARIO gives the number of the case, and a remark."""
    speed = "(8 + {}(X)) * 1 m/s"
    for name, said in {"sign": True, "floor": False}.items():
        driving = f", with behavior FollowLaneBehavior(target_speed={speed.format(name)})\nterminate after 0.5 s\n"
        text = SCENARIO.format(x=-40, speed="8 m/s").rstrip() + driving
        words = ("export", "case.scn", "--to", "xosc", "--mode", "maneuver", "--out", name)
        assert ("nothing in the file depends on X" in product.says(text, *words)) == said
