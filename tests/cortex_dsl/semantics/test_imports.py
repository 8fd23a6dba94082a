"""Imports: names of their own, read once, and every mistake reported in the file where it stands."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from cortex_dsl.diagnostics import CompileError, Diagnostic
from cortex_dsl.files import Folder
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.report.findings.snippet import render_text
from cortex_dsl.semantics.names import linking
from cortex_dsl.source import Source
from engine.program import load_program, save_program

CARS = """
from lib.gaps import GAP
param LIMIT = Range(3, 9) m/s

class Taxi(Car):
    speed: LIMIT

behavior Slow():
    do FollowLaneBehavior(target_speed=LIMIT / 2)

require GAP > 4 m
"""
GAPS = "GAP = Range(3, 9) m\nother = 3\n"
FILES = {"cars.scn": CARS, "lib/gaps.scenic": GAPS}
MAP = "map intersection()\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        write(tmp_path, name, text)
    return tmp_path


def write(folder: Path, name: str, text: str) -> None:
    (folder / name).parent.mkdir(exist_ok=True)
    (folder / name).write_text(text)


def compiled(folder: Path, text: str, overrides: Mapping[str, str] = {}) -> Compiled:
    return compile_source(Source("main.scn", MAP + text), overrides, files=Folder(folder))


def refused(folder: Path, text: str) -> tuple[Source, tuple[Diagnostic, ...]]:
    with pytest.raises(CompileError) as caught:
        compiled(folder, text)
    return caught.value.source, caught.value.diagnostics


@pytest.mark.parametrize(
    "text",
    [
        "import cars\nego = new Car on road, with speed cars.LIMIT, with behavior cars.Slow()\n",
        "import cars as c\nego = new Car on road, with speed c.LIMIT, with behavior c.Slow\n",
        "from cars import Slow as Crawl, Taxi\nego = new Taxi on road, with behavior Crawl()\n",
        "from cars import *\nego = new Taxi on road, with behavior Slow()\n",
        'import "cars.scn" as c\nfrom "cars" import Taxi\nego = new Taxi on road, with speed c.LIMIT\n',
        "from cars import Taxi\nego = new Taxi on road, with mass globalParameters.LIMIT * 1 t / 1 m * 1 s\n",
    ],
)
def test_names_are_reached_through_the_import(folder: Path, text: str) -> None:
    """Params of an imported file are genes, its requirements hold, however its names are reached."""
    program = compiled(folder, text).program
    assert program.space.names == ("LIMIT",)
    assert program.requirements[0].name == "GAP > 4 m"
    assert program.place(program.requirements[0].line).endswith("cars.scn:11")


def test_names_of_an_imported_file_stay_its_own(folder: Path) -> None:
    """`GAP` of the imported file is no name of the main one, and the other way round."""
    assert [d.code for d in refused(folder, "import cars\nego = new Car on road\nrequire GAP > 3 m\n")[1]] == ["SCN201"]
    write(folder, "use.scn", "x = SPEED\n")
    source, found = refused(folder, "SPEED = 3 m/s\nimport use\nego = new Car on road, with speed SPEED\n")
    assert [(d.code, Path(source.file(d.label.span.start).name).name) for d in found] == [("SCN201", "use.scn")]


def test_a_file_is_read_once(folder: Path) -> None:
    """Two ways to a file lead to the same values: its draws are drawn once."""
    text = "import cars\nfrom lib.gaps import GAP\nego = new Car on road\nrequire GAP > 5 m\n"
    (variant,) = compiled(folder, text).scenario.variants
    assert len([site for site in variant.draw_sites if site.kind == "number"]) == 1


def test_params_of_imported_files_can_be_held(folder: Path) -> None:
    text = "from cars import Taxi\nego = new Taxi on road\n"
    assert compiled(folder, text, {"LIMIT": "5"}).program.space.names == ()


def test_objects_of_an_imported_file_come_along(folder: Path) -> None:
    write(folder, "posts.scn", "post = new Obstacle at (9 m, 2 m)\n")
    program = compiled(folder, "import posts\nego = new Car ahead of posts.post by 5 m\n").program
    assert program.actors == ("ego", "post")


def test_missing_files_are_answered_with_those_there(folder: Path) -> None:
    _, (first, second) = refused(folder, 'import crs\nfrom "lib/gap.scenic" import GAP\nego = new Car on road\n')
    assert (first.code, first.cure) == ("SCN230", "did you mean `cars`?")
    assert (second.code, second.cure) == ("SCN230", "did you mean `lib/gaps.scenic`?")


def test_no_cure_is_a_cycle(folder: Path) -> None:
    """Neither the importing file nor one that imports it is suggested, by whatever path."""
    write(folder, "mix.scn", 'import "nix.scn"\n')
    write(folder, "tix.scn", 'import "mix.scn"\n')
    for path in ("tix.scn", "lib/../tix.scn"):
        found = refused(folder, f'import "{path}"\nego = new Car on road\n')[1]
        assert [d.code for d in found] == ["SCN230"]
        assert "mix.scn" not in found[0].cure
        assert "tix.scn" not in found[0].cure
    (folder / "alone").mkdir()
    write(folder, "alone/mix.scn", 'import "nix.scn"\n')
    found = refused(folder, 'import "alone/mix.scn"\nego = new Car on road\n')[1]
    assert found[0].cure == "there is no other scenario file in that folder"


def test_a_cycle_is_shown(folder: Path) -> None:
    write(folder, "a.scn", "import b\n")
    write(folder, "b.scn", "import a\n")
    _, (found,) = refused(folder, "import a\nego = new Car on road\n")
    assert found.code == "SCN231"
    assert found.message.replace(str(folder) + "/", "") == "this file imports itself: a.scn -> b.scn -> a.scn"


def test_a_missing_name_is_reported_with_the_nearest(folder: Path) -> None:
    _, found = refused(folder, "from cars import Taxo\nego = new Car on road\n")
    assert [(d.code, d.cure) for d in found] == [("SCN235", "did you mean `Taxi`?")]


@pytest.mark.parametrize(
    "line",
    [
        "map intersection()",
        "ego = new Car on road",
        "terminate when 3 > 2",
        "terminate after 3 s",
        "simulation(time_step=0.1 s)",
    ],
)
def test_what_the_run_decides_stays_in_the_main_file(folder: Path, line: str) -> None:
    write(folder, "bad.scn", line + "\n")
    assert "SCN236" in [d.code for d in refused(folder, "import bad\nego = new Car on road\n")[1]]


def test_a_path_with_dots_needs_a_name(folder: Path) -> None:
    _, found = refused(folder, "import lib.gaps\nego = new Car on road\n")
    assert [(d.code, d.cure) for d in found] == [("SCN234", "write `import lib.gaps as gaps`")]


def test_syntax_errors_show_the_imported_file(folder: Path) -> None:
    write(folder, "broken.scn", "# one\nx = [1, 2\n")
    source, found = refused(folder, "import broken\nego = new Car on road\n")
    text = render_text(source, found)
    assert text.replace(str(folder) + "/", "").startswith("broken.scn:2:")
    assert "2 | x = [1, 2" in text


def test_there_is_a_limit(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(linking, "FILE_LIMIT", 1)
    assert [d.code for d in refused(folder, "import cars\nego = new Car on road\n")[1]] == ["SCN232"]


def test_missing_files_are_not_reported_without_end(folder: Path) -> None:
    """A generated file with thousands of wrong imports is answered soon."""
    found = refused(folder, "".join(f"import nowhere{i}\n" for i in range(150)) + "ego = new Car on road\n")[1]
    assert [d.code for d in found] == ["SCN230"] * linking.FILE_LIMIT


def test_only_files_are_suggested(folder: Path) -> None:
    """A folder whose name ends in .scn is no cure."""
    (folder / "depot.scn").mkdir()
    found = refused(folder, "import depot\nego = new Car on road\n")[1]
    assert "`depot`" not in found[0].cure


def test_a_program_with_imports_is_saved_whole(folder: Path, tmp_path: Path) -> None:
    program = compiled(folder, "from cars import Taxi\nego = new Taxi on road\n").program
    save_program(program, tmp_path / "p.npz")
    assert load_program(tmp_path / "p.npz").imported == program.imported
