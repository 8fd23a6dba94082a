"""A new metric is one kernel and one row: every file, view and page then has it.

A copy of the product gets both, as a maintainer would write them, and runs without the compiler in processes of its
own.
"""

import csv
import json
import os
import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.fork_server import RUN, ForkServer

ROOT = Path(__file__).parent.parent
NAME, SYMBOL, MEANING = "sum_of_speeds", "V_SUM", "sum of both speeds at the instant of MD"
ROW = f'''
    {NAME}: Annotated[
        Floats,
        Result("sum of both speeds then [m/s]", "m/s", "{SYMBOL}", "{MEANING}", Per.PAIR, retention=Retention.DECIDING),
    ]'''
KERNEL = '''

@inlined
def _sum_of_speeds(approach: Approach) -> float:
    """Of the rear axles, at the instant of MD [m/s]."""
    return approach.ego_speed + approach.other_speed
'''
BEFORE = {
    "engine/outcomes.py": {"\n    left_road_time: Annotated[": ROW},
    "engine/kernels/pair.py": {
        "        side=float(approach.side),\n": f"        {NAME}=_sum_of_speeds(approach),\n",
        "        side=-1.0,\n": f"        {NAME}=math.nan,\n",
        "\n\n@inlined\ndef _mix(": KERNEL,
    },
}
"""The lines that a maintainer writes, by the place that they stand before."""
SCENARIO = """\
param GAP = Range(50, 60) m
ego = new Car at (-40, -1.75), facing 0 deg, with speed 8 m/s
other = new Car at (GAP - 40 m, -1.75), facing 0 deg, with speed 2 m/s
terminate after 1 s
"""
API = """
from pathlib import Path
from cortex_dsl.api.scenario import load
scenario = load(Path("meeting.scn"))
table = scenario.table(scenario.simulate(scenario.sample()))
print([(name, column.tolist()) for name, column in table.items() if "sum" in name])
"""
LOADED = """
import sys
from cortex_dsl.__main__ import process
from cortex_dsl.api import runs, scenario
from cortex_dsl.cli import main
from cortex_dsl.report.page import run_page
from engine import batch, world
"""


PAGE = """
import sys
from cortex_dsl.api.runs import open_run
from cortex_dsl.report.page.run_page import run_page
print(run_page(open_run(sys.argv[1]), cases=1, budget=0))
"""
"""Without the 20,000 simulations that find out which params matter, which take long in plain Python."""


class Product:
    """A copy of the product that has the metric."""

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
        (folder / "meeting.scn").write_text(SCENARIO, encoding="utf-8")

    def run(self, code: str, *words: str) -> str:
        """What code prints, in a process that knows the product."""
        ended = self.server.run(code, *words, at=self.folder)
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


@pytest.fixture(scope="module")
def searched(product: Product) -> Path:
    """The folder of a search."""
    search = ("meeting.scn", "--random", "--generations", "1", "--population", "2", "--out", "run")
    product.run(RUN, *search)
    return product.folder / "run"


def test_reports_and_their_json_have_it(product: Product) -> None:
    """By its symbol and what it means; 8 and 2 m/s are 10."""
    document = json.loads(product.run(RUN, "meeting.scn", "--json"))
    assert document["pairs"][0][NAME] == pytest.approx(10.0)
    (metric,) = [each for each in document["metrics"] if each["name"] == SYMBOL]
    assert (metric["unit"], metric["meaning"]) == ("m/s", MEANING)
    report = product.run(RUN, "meeting.scn", "--metrics")
    assert SYMBOL in report
    assert MEANING in report


def test_python_has_it(product: Product) -> None:
    """As a column with its unit."""
    assert f"other.{NAME} [m/s]" in product.run(API)


def test_journal_csv_and_guide_have_it(searched: Path) -> None:
    """A column in each, and what it means."""
    with closing(sqlite3.connect(searched / "journal.sqlite")) as journal:
        assert [row[0] for row in journal.execute(f"SELECT {NAME} FROM simulation")] == pytest.approx([10.0, 10.0])
    with (searched / "evaluations.csv").open(encoding="utf-8") as file:
        assert [float(row[NAME]) for row in csv.DictReader(file)] == pytest.approx([10.0, 10.0])
    lines = (searched / "evaluations.jsonl").read_text(encoding="utf-8").splitlines()
    assert [json.loads(line)[NAME] for line in lines] == pytest.approx([10.0, 10.0])
    assert f"| `{NAME}` | sum of both speeds then [m/s] |" in (searched / "README.md").read_text(encoding="utf-8")


def test_pages_have_it(product: Product, searched: Path) -> None:
    """The journal is read back, and each case tells it."""
    assert MEANING in product.run(PAGE, searched.name)
