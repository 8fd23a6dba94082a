"""Guards, picks, monitors, temporal requirements and records: checked IR made by hand, lowered, and run in both hosts.

As in `test_behaviours`, a throttle of n hundredths shows which act ran.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from cortex_dsl import compile_text, ir
from cortex_dsl.lowering import lower
from cortex_dsl.lowering.program_listing import format_program
from cortex_dsl.semantics.printing import format_ir
from cortex_dsl.source import Span
from engine import batch, world
from engine.config import Config, SimulationConfig
from engine.metrics import recorded
from engine.opcodes import Op
from engine.program import Program
from engine.sampling import draw_genomes, sample
from engine.scenes import Scenes, Trajectory
from engine.streams import key_rows
from engine.vocabulary import Command, EndReason, RuleKind, State, TemporalOp, Turns, Verdict

HERE = Span(0, 1)
STEP = 1.0
TEXT = """
map intersection(approach=100 m)
ego = new Car at (-90 m, -1.75 m), facing 0 deg, with speed 1 m/s
other = new Car at (-50 m, -1.75 m), facing 0 deg, with speed 1 m/s
"""
TIME = ir.Apply(HERE, Op.TIME, ())


def number(value: float) -> ir.Expr:
    return ir.Literal(HERE, value)


TRUE, FALSE = number(1.0), number(0.0)


def act(hundredths: int) -> ir.Act:
    return ir.Take(HERE, ((Command.THROTTLE, number(hundredths / 100)),))


def before(seconds: float) -> ir.Expr:
    return ir.Apply(HERE, Op.LT, (TIME, number(seconds)))


def scope(*body: ir.Act, number: int = 0, invariants: Sequence[tuple[ir.Expr, int]] = ()) -> ir.Scope:
    return ir.Scope(HERE, "Inner", number, body, tuple(invariants))


@pytest.fixture(scope="module")
def base() -> ir.Scenario:
    """Two cars that coast, 40 m apart."""
    return compile_text(TEXT).compiled.scenario


ABORT = ir.Rule(None, "guard", 1, RuleKind.ABORT)


def program(
    base: ir.Scenario,
    *behaviour: ir.Act,
    rules: Sequence[ir.Rule] = (ABORT,),
    monitors: Sequence[ir.Monitor] = (),
    temporals: Sequence[ir.Temporal] = (),
    records: Sequence[ir.Record] = (),
    locals_: int = 4,
    **other: object,
) -> Program:
    (variant,) = base.variants
    ego = replace(variant.actors[0], behaviour=behaviour or None)
    changed = replace(
        variant,
        actors=(ego, replace(variant.actors[1], **other)),
        rules=tuple(rules),
        monitors=tuple(monitors),
        local_count=locals_,
    )
    return lower(replace(base, variants=(changed,), temporals=tuple(temporals), records=tuple(records)))


def config(steps: int) -> SimulationConfig:
    return SimulationConfig(time_step=STEP, max_time=steps * STEP)


def scenes(program: Program, count: int = 1) -> Scenes:
    keys = key_rows(0, 1, 0, 0, range(count))
    return sample(program, draw_genomes(program.space, keys), keys, config(9))


def trajectory(program: Program, steps: int = 9, row: int = 0) -> Trajectory:
    """States in the batch host; the world's are the same."""
    drawn = scenes(program, row + 1)
    fast = batch.trajectory(program, drawn, row, config(steps))
    slow = world.run(program, drawn, row, Config(simulation=config(steps)))
    np.testing.assert_allclose(slow.trajectory.states, fast.states, atol=1e-9)
    outcome = batch.simulate(program, drawn, config(steps))
    for name in ("verdict", "end_reason", "end_rule", "end_time", "steps"):
        assert getattr(slow.outcomes, name)[0] == getattr(outcome, name)[row]
    return fast


def trace(program: Program, steps: int = 9, row: int = 0) -> list[int]:
    """Hundredths of throttle of each step up to the end of the run."""
    return [round(100 * throttle) for throttle in trajectory(program, steps, row).states[1:, 0, State.THROTTLE]]


def ending(program: Program, steps: int = 9) -> tuple[Verdict, EndReason, int, float]:
    outcome = batch.simulate(program, scenes(program), config(steps))
    reason, rule = EndReason(int(outcome.end_reason[0])), int(outcome.end_rule[0])
    return Verdict(int(outcome.verdict[0])), reason, rule, float(outcome.end_time[0])


def aborted(rule: int, time: float) -> tuple[Verdict, EndReason, int, float]:
    return Verdict.ABORTED, EndReason.ABORTED, rule, time


VALID = (Verdict.VALID, EndReason.TIMEOUT, -1, 9.0)


def test_a_demand_that_is_not_met_aborts_the_run(base: ir.Scenario) -> None:
    """Where it stands, at its time, by its rule; one that holds does nothing."""
    held = program(base, ir.Demand(HERE, TRUE, 0), act(1))
    assert trace(held, 2) == [1, 0]
    broken = program(base, act(1), act(2), ir.Demand(HERE, FALSE, 1), act(3), rules=(ABORT, ABORT))
    assert trace(broken) == [1, 2]
    assert ending(broken) == aborted(1, 2.0)


def test_a_demand_that_is_not_a_number_is_an_error_of_the_run(base: ir.Scenario) -> None:
    """NaN is neither true nor false."""
    nan = ir.Apply(HERE, Op.SQRT, (ir.Apply(HERE, Op.SUB, (TIME, number(1.0))),))
    assert ending(program(base, ir.Demand(HERE, nan, 0)))[:2] == (Verdict.ERROR, EndReason.BROKEN)


def test_invariants_hold_at_the_start(base: ir.Scenario) -> None:
    """Before the first act."""
    broken = program(base, act(1), scope(act(2), invariants=[(FALSE, 0)]))
    assert ending(broken) == aborted(0, 1.0)
    assert trace(broken) == [1]


def test_invariants_are_tested_when_the_body_goes_on(base: ir.Scenario) -> None:
    """In each later turn of its own, not at its end, and not behind it."""
    body = (act(1), act(2), act(3))
    assert ending(program(base, scope(*body, invariants=[(before(1.5), 0)]))) == aborted(0, 2.0)
    assert ending(program(base, scope(*body, invariants=[(before(3.5), 0)]))) == VALID


def test_invariants_rest_while_an_inner_behaviour_runs(base: ir.Scenario) -> None:
    """They are tested when it has ended; its own are tested in its turns."""
    inner = scope(act(1), act(2), act(3), number=1)
    dip = ir.Apply(HERE, Op.OR, (before(0.5), ir.Apply(HERE, Op.LT, (number(2.5), TIME))))
    assert ending(program(base, scope(inner, act(4), invariants=[(dip, 0)]))) == VALID
    assert ending(program(base, scope(inner, act(4), invariants=[(before(2.5), 0)]))) == aborted(0, 3.0)
    picky = scope(act(1), act(2), number=1, invariants=[(before(0.5), 1)])
    both = program(base, scope(picky, invariants=[(before(0.5), 0)]), rules=(ABORT, ABORT))
    assert ending(both) == aborted(1, 1.0)


def test_invariants_rest_while_a_handler_above_runs(base: ir.Scenario) -> None:
    """An interrupt outside the scope takes the turn, so the body does not go on."""
    handler = (ir.Apply(HERE, Op.EQ, (TIME, number(2.0))), (act(9),))
    inner = scope(
        *(act(n) for n in range(1, 6)), number=1, invariants=[(ir.Apply(HERE, Op.NE, (TIME, number(2.0))), 0)]
    )
    watched = program(base, ir.TryInterrupt(HERE, (inner,), (handler,)))
    assert trace(watched, 6) == [1, 2, 9, 3, 4, 5]
    assert ending(watched) == VALID


def option(*body: ir.Act, weight: float = 1.0, allowed: ir.Expr = TRUE) -> ir.Option:
    return ir.Option(number(weight), allowed, body)


def chosen(pick: Program, steps: int, count: int) -> list[list[int]]:
    drawn = scenes(pick, count)
    runs = (batch.trajectory(pick, drawn, row, config(steps)).states for row in range(count))
    return [[round(100 * throttle) for throttle in states[1:, 0, State.THROTTLE]] for states in runs]


def test_choose_picks_by_weight_among_the_allowed(base: ir.Scenario) -> None:
    """Each as often as its weight says; one that is not allowed, never; what follows goes on behind it."""
    options = (option(act(1), act(1)), option(act(2), weight=3.0), option(act(3), weight=9.0, allowed=FALSE))
    pick = program(base, ir.Pick(HERE, options, False, 0), act(7))
    found = chosen(pick, 4, 400)
    assert {tuple(run) for run in found} == {(1, 1, 7, 0), (2, 7, 0, 0)}
    assert sum(run[0] == 2 for run in found) == pytest.approx(300, abs=40)


def test_choose_is_asked_anew_in_every_round(base: ir.Scenario) -> None:
    """In a loop, draws differ from turn to turn, and a scene draws the same again."""
    body = ir.Loop(HERE, TRUE, (ir.Pick(HERE, (option(act(1)), option(act(2))), False, 0),))
    found = chosen(program(base, body), 9, 30)
    assert len({tuple(run) for run in found}) > 20
    assert found == chosen(program(base, body), 9, 30)


def test_shuffle_takes_all_in_any_order(base: ir.Scenario) -> None:
    """Every order occurs; each option once a round, and a second round starts afresh."""
    options = tuple(option(act(n), act(n)) for n in (1, 2, 3))
    twice = program(base, ir.Pick(HERE, options, True, 0), ir.Pick(HERE, options, True, 0), act(7))
    found = chosen(twice, 13, 120)
    assert {tuple(run[0:6:2]) for run in found} == set(permutations((1, 2, 3)))
    assert {tuple(sorted(run[6:12:2])) for run in found} == {(1, 2, 3)}
    assert {run[12] for run in found} == {7}


def test_shuffle_asks_what_is_allowed_at_each_pick(base: ir.Scenario) -> None:
    """One that is allowed only later comes later; one that never is aborts the run when it alone is left."""
    late = option(act(2), allowed=ir.Apply(HERE, Op.LT, (number(0.5), TIME)))
    assert {tuple(run) for run in chosen(program(base, ir.Pick(HERE, (late, option(act(1))), True, 0)), 3, 20)} == {
        (1, 2, 0)
    }
    never = program(base, ir.Pick(HERE, (option(act(2), allowed=FALSE), option(act(1))), True, 0))
    assert ending(never) == aborted(0, 1.0)


def test_where_nothing_is_allowed_the_run_is_aborted(base: ir.Scenario) -> None:
    """By the rule of the statement."""
    none = program(base, act(1), ir.Pick(HERE, (option(act(2), allowed=FALSE),), False, 0))
    assert ending(none) == aborted(0, 1.0)


def monitor(name: str, *body: ir.Act, turns: Turns = Turns.FROM_START) -> ir.Monitor:
    return ir.Monitor(name, body, turns, HERE)


def wait(turns: int) -> tuple[ir.Act, ...]:
    return (ir.Wait(HERE),) * turns


def test_a_monitor_runs_beside_the_actors(base: ir.Scenario) -> None:
    """Its `require` aborts, its locals are seen by behaviours."""
    watcher = monitor("Watch", *wait(3), ir.Demand(HERE, before(2.5), 0))
    assert ending(program(base, monitors=[watcher])) == aborted(0, 3.0)
    count = ir.SetLocal(HERE, 0, ir.Apply(HERE, Op.ADD, (ir.Local(HERE, 0), number(0.01))))
    counter = monitor("Count", ir.Loop(HERE, TRUE, (count, *wait(1))))
    echo = ir.Loop(HERE, TRUE, (ir.Take(HERE, ((Command.THROTTLE, ir.Local(HERE, 0)),)),))
    assert trace(program(base, echo, monitors=[counter]), 4) == [1, 2, 3, 4]


def test_a_scenario_starts_others_and_waits_for_them(base: ir.Scenario) -> None:
    """The other actor comes in with the child, brakes as its behaviour says, and coasts when the child is stopped."""
    children = ir.Loop(HERE, ir.Apply(HERE, Op.AND, (ir.Running(HERE, 1), before(4.5))), wait(1))
    parent = monitor("Main", *wait(2), ir.Start(HERE, 1), children, ir.Stop(HERE, (1,), (1,)), *wait(1))
    child = monitor("Sub", ir.Spawn(HERE, (1,)), ir.Loop(HERE, TRUE, wait(1)), turns=Turns.LATER)
    throttle = ir.Loop(HERE, TRUE, (act(50),))
    states = trajectory(program(base, monitors=[parent, child], present=False, behaviour=(throttle,))).states[:, 1]
    assert list(states[:, State.PRESENT]) == [0, 0, 1, 1, 1, 1, 1, 1, 1, 1]
    assert list(states[1:, State.THROTTLE]) == [0, 0, 0.5, 0.5, 0.5, 0, 0, 0, 0]
    assert list(states[:3, State.X]) == [-50.0] * 3


def test_a_child_that_ends_is_no_longer_running(base: ir.Scenario) -> None:
    """A parent goes on in the next sample; a child with a higher number has its first turn at once."""
    parent = monitor(
        "Main",
        ir.Start(HERE, 1),
        ir.Loop(HERE, ir.Running(HERE, 1), wait(1)),
        ir.Terminate(HERE, 0),
    )
    child = monitor("Sub", *wait(2), turns=Turns.LATER)
    rules = (ir.Rule(None, "done", 1),)
    assert ending(program(base, monitors=[parent, child], rules=rules))[1:] == (EndReason.RULE, 0, 3.0)


def test_a_caller_sees_the_end_of_what_it_advances_at_once(base: ir.Scenario) -> None:
    """Two side by side, of two and of three turns, and one within one of them, have their turns in their caller's."""
    going = ir.Apply(HERE, Op.OR, (ir.Running(HERE, 1), ir.Running(HERE, 2)))
    turns = (ir.Advance(HERE, 1), ir.Advance(HERE, 2), ir.Branch(HERE, going, wait(1), ()))
    starts = ir.Start(HERE, 1), ir.Start(HERE, 2)
    parent = monitor("Main", *starts, ir.Loop(HERE, going, turns), ir.Terminate(HERE, 0), turns=Turns.BEFORE_RULES)
    short = monitor("Short", *wait(2), turns=Turns.CALLED)
    inner = ir.Loop(HERE, ir.Running(HERE, 3), (ir.Advance(HERE, 3), *wait(1)))
    long = monitor("Long", ir.Start(HERE, 3), inner, turns=Turns.CALLED)
    within = monitor("Within", *wait(2), turns=Turns.CALLED)
    rules = (ir.Rule(None, "done", 1),)
    whole = program(base, monitors=[parent, short, long, within], rules=rules)
    assert ending(whole)[1:] == (EndReason.RULE, 0, 3.0)


def test_what_must_always_hold_counts_where_the_scenario_ends_the_run(base: ir.Scenario) -> None:
    """The scenario acts before the rules, but its end is drawn once they have been looked at."""
    parent = monitor("Main", *wait(3), ir.Terminate(HERE, 0), turns=Turns.BEFORE_RULES)
    done, late = (
        ir.Rule(None, "done", 1),
        ir.Rule(ir.Apply(HERE, Op.LT, (number(2.5), TIME)), "late", 1, RuleKind.ABORT),
    )
    assert ending(program(base, monitors=[parent], rules=(done, late))) == aborted(1, 3.0)


def atom(rule: int) -> ir.Formula:
    return ir.Formula(TemporalOp.ATOM, (), rule)


@pytest.mark.parametrize(
    ("operator", "expected"),
    [(TemporalOp.ALWAYS, aborted(1, 4.0)), (TemporalOp.EVENTUALLY, VALID), (TemporalOp.NEXT, VALID)],
)
def test_temporal_requirements_over_watched_conditions(base: ir.Scenario, operator, expected) -> None:
    """`before 3.5 s` always, at some time, in the next sample."""
    rules = (ir.Rule(before(3.5), "early", 1, RuleKind.WATCH), ABORT)
    temporal = ir.Temporal(ir.Formula(operator, (atom(0),)), 1)
    assert ending(program(base, rules=rules, temporals=[temporal])) == expected


def test_until_and_implies(base: ir.Scenario) -> None:
    """(early until late) holds where the one begins as the other ends, and not with a gap between them."""
    late = {after: ir.Apply(HERE, Op.LT, (number(after), TIME)) for after in (3.5, 5.5)}
    for after, expected in ((3.5, VALID), (5.5, aborted(2, 9.0))):
        rules = (
            ir.Rule(before(3.5), "early", 1, RuleKind.WATCH),
            ir.Rule(late[after], "late", 1, RuleKind.WATCH),
            ABORT,
        )
        until = ir.Formula(TemporalOp.UNTIL, (atom(0), atom(1)))
        implied = ir.Formula(TemporalOp.IMPLIES, (atom(0), until))
        assert ending(program(base, rules=rules, temporals=[ir.Temporal(implied, 2)])) == expected


def test_records_keep_what_they_watch(base: ir.Scenario) -> None:
    """Over time, at the start and at the end, with their units."""
    x = ir.Apply(HERE, Op.STATE, (), (0, int(State.X)))
    rules = (ir.Rule(x, "x", 1, RuleKind.WATCH),)
    length = ir.Dimension(length=1)
    records = [ir.Record(when, when, 0, length, 3) for when in ("series", "initial", "final")]
    recording = program(base, rules=rules, records=records)
    series, initial, final = recorded(recording, trajectory(recording, 3))
    assert (series.name, series.unit, series.line) == ("series", "m", 3)
    assert list(series.values) == [-90, -89, -88, -87]
    assert list(series.time) == [0, 1, 2, 3]
    assert (list(initial.values), list(final.values), list(final.time)) == ([-90], [-87], [3])
    lived = world.run(recording, scenes(recording), 0, Config(simulation=config(3)))
    assert [list(record.values) for record in lived.records] == [list(r.values) for r in (series, initial, final)]


def test_questions_about_others(base: ir.Scenario) -> None:
    """Who leads, how soon outlines would touch, which lane: the instructions with their immediates and widths."""
    path = ir.Apply(HERE, Op.LANE_ROUTE, (ir.Pack(HERE, tuple(map(number, (-90.0, -1.75, 0.0)))),))
    lead = ir.Apply(HERE, Op.LEAD, (path, number(math.inf)), (0,), 2)
    ttc = ir.Apply(HERE, Op.TTC, (), (0, -1))
    pose = ir.Pack(HERE, tuple(ir.Apply(HERE, Op.STATE, (), (0, column)) for column in range(3)))
    lane = ir.Apply(HERE, Op.LANE_NEAREST, (pose,))
    asked = (ir.Item(HERE, lead, 0), ir.Item(HERE, lead, 1), ttc, lane)
    rules = tuple(ir.Rule(e, "asked", 1, RuleKind.WATCH) for e in asked)
    faster = ir.Take(HERE, ((Command.SPEED, number(3.0)),))
    watched = trajectory(program(base, faster, rules=rules), 2).watched
    gap = 40.0 - 4.508
    np.testing.assert_allclose(watched[0], [gap, 1.0, np.inf, watched[0, 3]])
    np.testing.assert_allclose(watched[1, :3], [gap - 2.0, 1.0, (gap - 2.0) / 2.0])
    assert base.network.lanes[int(watched[0, 3])].path >= 0


def test_listings_show_all_of_it(base: ir.Scenario) -> None:
    """The program's listing and the IR's name monitors, kinds of rules, formulas and records."""
    rules = (ir.Rule(before(3.5), "early", 1, RuleKind.WATCH), ABORT)
    turn = ir.Advance(HERE, 1), *wait(1)
    parent = monitor("Main", ir.Start(HERE, 1), ir.Loop(HERE, ir.Running(HERE, 1), turn), turns=Turns.BEFORE_RULES)
    child = monitor("Sub", ir.Spawn(HERE, (1,)), ir.Stop(HERE, (), (1,)), turns=Turns.CALLED)
    temporal = ir.Temporal(ir.Formula(TemporalOp.ALWAYS, (atom(0),)), 1)
    record = ir.Record("early", "final", 0, ir.PURE, 1)
    picks = ir.Pick(HERE, (option(act(1), weight=2.0), option(act(2))), True, 1)
    guarded = scope(ir.Demand(HERE, TRUE, 1), picks, invariants=[(before(5.0), 1)])
    (variant,) = base.variants
    actors = (replace(variant.actors[0], behaviour=(guarded,)), replace(variant.actors[1], present=False))
    changed = replace(variant, actors=actors, rules=rules, monitors=(parent, child), local_count=4)
    scenario = replace(base, variants=(changed,), temporals=(temporal,), records=(record,))
    text = format_program(lower(scenario))
    for words in (
        "rule 0 'early' (line 1): watch", "rule 1 'guard' (line 1): abort", "requirement always rule0, else rule 1",
        "record final 'early': rule 0", "monitor 0 Main, from the start", "monitor 1 Sub, advanced by another",
        "is_running", "spawn            actor 1", "absent at the start",
    ):  # fmt: skip
        assert words in text, words
    text = format_ir(scenario)
    for words in (
        "rule 0: watch", "rule 1: abort when code says so", "require always rule0, else rule 1", "record final early",
        "monitor 0 Main", "start monitor 1", "advance monitor 1", "while running(1)", "spawn actor 1", "stop actor 1",
        "shuffle, else rule 1", "option 2.0", "invariant", "demand 1.0, else rule 1", "absent at the start",
    ):  # fmt: skip
        assert words in text, words
