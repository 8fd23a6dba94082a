"""`domain`: its cells, and that it changes neither scenes nor runs."""

import re

import numpy as np
import pytest

import cortex_dsl as cx
from cortex_dsl import ir
from cortex_dsl.api.scenario import Scenario
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import Compiled, compile_source
from cortex_dsl.source import Source
from engine.vocabulary import Column

FILE = """\
map intersection(ways=4, lanes=1)
param V = Range(10 km/h, 60 km/h)
param LIGHT = Uniform(0.05, 0.5, 1.0)
param KIND = Uniform("calm", "quick")
gap = Range(5, 30)
ego = new Car on road, with speed V
other = new Car ahead of ego by gap, with speed (4 m/s if KIND == "calm" else 6 m/s)
require V <= 50 km/h as "limit"
expect always (minimum distance from ego to other) > 1 m as "room"
{lines}
terminate after 3 s
"""
LINES = (
    'domain "speed" ego.speed in 10 km/h steps from 0 km/h to 60 km/h',
    'domain "light" LIGHT at start in [0.05, 0.5, 1.0]',
    'domain "kind" KIND in ["calm", "quick"]',
    'domain "gap" distance from ego to other at end in [(0 m, 10 m), (10 m, 40 m)]',
    'domain "impact" ego.speed at contact in 15 km/h steps from 0 km/h to 60 km/h',
    'domain "near" (distance from ego to other < 12 m) at start in [True, False]',
    'domain "drawn" gap in [(0, 10), (10, 20)]',
    'domain "heading" relative heading of other in 30 deg steps from -90 deg to 90 deg',
    'domain "bare" V / (1 km/h) in 10 steps from 0 to 60',
    'domain "seen" distance from ego to other at first sight in [(0 m, 10 m), (10 m, 40 m)]',
)


def compiled(*lines: str, use: ir.DomainUse | None = None) -> Compiled:
    return compile_source(Source("a.scn", FILE.format(lines="\n".join(lines))), domains=use)


def codes(*lines: str) -> list[str]:
    """Return the codes of all errors."""
    try:
        compiled(*lines)
    except CompileError as error:
        return [each.code for each in error.diagnostics]
    return []


@pytest.mark.parametrize("lines", [*((line,) for line in LINES), LINES], ids=lambda lines: lines[0][8:14])
def test_a_domain_changes_neither_program_nor_scenes_nor_runs(lines: tuple[str, ...]) -> None:
    """The program is that of the file without the lines, and the program that measures draws and runs the same."""
    plain = compiled(*("#" for _ in lines))
    given = compiled(*lines)
    assert given.program.digest == plain.program.digest
    assert len(given.scenario.domains) == len(lines)
    measured = compiled(*lines, use=ir.DomainUse())
    one, other = (Scenario(each, cx.Config(), {}) for each in (plain, measured))
    scenes, again = one.sample(60, seed=3), other.sample(60, seed=3)
    for name in ("verdict", "genomes", "draws", "variant", "attempts", "failed"):
        assert np.array_equal(getattr(scenes, name), getattr(again, name), equal_nan=True), name
    placed = 2 * len(Column)  # values that only a program gives to its run come after those of the actors
    assert np.array_equal(scenes.values[:, :placed], again.values[:, :placed], equal_nan=True)
    runs, measured_runs = one.simulate(scenes), other.simulate(again)
    for name in ("verdict", "end_reason", "end_time", "collided", "min_distance"):
        assert np.array_equal(getattr(runs, name), getattr(measured_runs, name), equal_nan=True), name
    assert np.array_equal(runs.sought[:, 0], measured_runs.sought[:, 0], equal_nan=True)


def test_values_at_each_instant_are_those_of_the_run() -> None:
    """At the start the param, at contact a finite value in collisions only, at the end the last sample."""
    lines = LINES[0], LINES[3], LINES[4], LINES[6]
    program = compiled(*lines, use=ir.DomainUse())
    scenario = Scenario(program, cx.Config(), {})
    scenes = scenario.sample(200, seed=1)
    runs = scenario.simulate(scenes)
    valid = scenes.valid
    speed, gap, impact, drawn = runs.sought[valid, 1:].T
    assert np.allclose(speed * 3.6, scenes.genomes[valid, 0], rtol=1e-12)
    collided = runs.collided[valid]
    assert collided.any()
    assert np.array_equal(np.isfinite(impact), collided)
    assert np.allclose(impact[collided], runs.ego_speed[valid][collided, 0], atol=1e-9)
    assert (gap[~collided] > 0.0).all()
    assert ((drawn >= 5.0) & (drawn <= 30.0)).all()


def test_cells_are_those_of_the_line() -> None:
    """Steps, values and intervals; an upper end belongs to a cell where no other cell begins."""
    speed, light, kind, gap = compiled(*LINES[:4]).scenario.domains
    assert [cell.text for cell in speed.cells[:2]] == ["0 to 10 km/h", "10 to 20 km/h"]
    assert [cell.closed for cell in speed.cells] == [False] * 5 + [True]
    assert speed.cells[2].high == 30.0 * (1.0 / 3.6)  # as the literal `30 km/h`
    assert (speed.least * 3.6, speed.greatest * 3.6) == pytest.approx((10.0, 60.0))
    assert [(cell.low, cell.high) for cell in light.cells] == [(0.05, 0.05), (0.5, 0.5), (1.0, 1.0)]
    assert [cell.text for cell in kind.cells] == ['"calm"', '"quick"']
    assert [cell.closed for cell in gap.cells] == [False, True]
    assert np.isnan(gap.least)


def test_steps_that_do_not_divide_the_range_have_a_shorter_last_cell() -> None:
    found = compiled('domain "speed" ego.speed in 25 km/h steps from 0 km/h to 60 km/h')
    assert [cell.text for cell in found.scenario.domains[0].cells] == ["0 to 25 km/h", "25 to 50 km/h", "50 to 60 km/h"]
    assert "SCN489" in [each.code for each in found.diagnostics]


@pytest.mark.parametrize(
    ("code", "line"),
    [
        ("SCN486", 'domain "a" ego.speed in 1 m/s steps from 0 m/s to V'),
        ("SCN486", 'domain "a" ego.speed in [V, 3 m/s]'),
        ("SCN487", 'domain "a" ego.speed in [(0, 5), (4, 9)]'),
        ("SCN487", 'domain "a" ego.speed in [5, 5]'),
        ("SCN487", 'domain "a" ego.speed in [5, (5, 9)]'),
        ("SCN487", 'domain "a" KIND in ["calm", "calm"]'),
        ("SCN488", 'domain "a" ego.speed in []'),
        ("SCN488", 'domain "a" ego.speed in [(9, 5)]'),
        ("SCN488", 'domain "a" ego.speed in 0 m/s steps from 0 m/s to 5 m/s'),
        ("SCN488", 'domain "a" ego.speed in 1 m/s steps from 5 m/s to 5 m/s'),
        ("SCN488", 'domain "a" ego.speed in 0.00001 m/s steps from 0 m/s to 5 m/s'),
        ("SCN499", 'domain "a" ego.speed + Range(0, 1) in [(0, 5)]'),
        ("SCN498", 'domain "" ego.speed in [(0, 5)]'),
        ("SCN210", 'domain "a" ego.speed in [(0, 5)]\ndomain "a" V in [(0, 5)]'),
        ("SCN302", 'domain "a" ego.speed in [(0 m, 5 m)]'),
        ("SCN201", 'domain "a" nobody in [1]'),
    ],
)
def test_a_wrong_domain_is_refused(code: str, line: str) -> None:
    assert code in codes(line)


def test_a_value_that_only_the_run_has_is_refused_at_the_start() -> None:
    assert codes('domain "a" simulation().currentTime in [(0, 5)]')
    assert not codes('domain "a" simulation().currentTime at end in [(0, 5)]')


def test_contact_needs_another_object() -> None:
    text = re.sub(r"(?m)^(other|expect).*\n", "", FILE).format(lines=LINES[4])
    with pytest.raises(CompileError) as refused:
        compile_source(Source("a.scn", text))
    assert [each.code for each in refused.value.diagnostics] == ["SCN495"]


def test_a_scenario_inside_a_scenario_has_no_domain() -> None:
    text = FILE.format(lines="").replace("terminate after 3 s\n", "")
    text += f"scenario Inner():\n    setup:\n        {LINES[0]}\nscenario Main():\n    compose:\n        do Inner()\n"
    with pytest.raises(CompileError):
        compile_source(Source("a.scn", text))


def test_domain_is_a_name_elsewhere() -> None:
    text = FILE.format(lines="domain = 4\nsteps = domain\nrequire steps == 4")
    assert not compile_source(Source("a.scn", text)).scenario.domains
