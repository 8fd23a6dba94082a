"""Temporal requirements: atoms, formulas, and what is known of them before any run."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from engine.opcodes import Op
from engine.vocabulary import RuleKind, State, TemporalOp

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]
END = "terminate after 9 s\n"
FAST, SLOW = "ego.speed > 6 m/s", "ego.speed < 2 m/s"


def shape(formula: ir.Formula, scenario: ir.Scenario) -> object:
    """A formula as nested tuples; atoms by the names of their rules."""
    if formula.op == TemporalOp.ATOM:
        return scenario.variants[0].rules[formula.watch].name
    return (formula.op.name.lower(), *(shape(operand, scenario) for operand in formula.operands))


@pytest.fixture
def formula(compiled: Compiled) -> Callable[[str], object]:
    """The shape of the one formula of a condition."""

    def of(condition: str) -> object:
        scenario = compiled(f"require {condition}\n" + END)
        (temporal,) = scenario.temporals
        return shape(temporal.formula, scenario)

    return of


def test_always_is_a_rule_that_aborts(compiled: Compiled) -> None:
    """`require always c` = abort when not c, at once; c may hold an `implies`."""
    assert compiled(f"require always ({FAST} implies {SLOW})\n" + END).temporals == ()
    scenario = compiled(f"require always {FAST}\n" + END)
    (rule,) = scenario.variants[0].rules
    assert (rule.kind, rule.name, rule.line) == (RuleKind.ABORT, f"always {FAST}", 4)
    assert isinstance(rule.condition, ir.Apply)
    assert rule.condition.op == Op.NOT
    (holds,) = rule.condition.arguments
    assert isinstance(holds, ir.Apply)
    assert holds.op == Op.LT
    assert scenario.temporals == ()


def test_another_temporal_requirement_is_a_formula(compiled: Compiled) -> None:
    """Its atoms are watched, and a rule without condition bears its name."""
    scenario = compiled(f'require eventually {FAST} as "fast once"\n' + END)
    (temporal,) = scenario.temporals
    watch, verdict = scenario.variants[0].rules
    assert (watch.kind, verdict.kind) == (RuleKind.WATCH, RuleKind.ABORT)
    assert verdict.condition is None
    assert scenario.variants[0].rules[temporal.rule].name == "fast once"
    assert temporal.formula == ir.Formula(TemporalOp.EVENTUALLY, (ir.Formula(TemporalOp.ATOM, watch=0),))


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        (f"next {FAST}", ("next", FAST)),
        (f"{FAST} until {SLOW}", ("until", FAST, SLOW)),
        (f"(always {FAST}) implies {SLOW}", ("implies", ("always", FAST), SLOW)),
        (f"eventually ({FAST} implies {SLOW})", ("eventually", f"{FAST} implies {SLOW}")),
        (f"always {FAST} implies next {SLOW}", ("always", ("implies", FAST, ("next", SLOW)))),
        (f"not always {FAST}", ("not", ("always", FAST))),
        (f"always ({FAST} or {SLOW}) until {SLOW}", ("until", ("always", f"{FAST} or {SLOW}"), SLOW)),
        (f"(next {FAST}) or (next {SLOW}) or {FAST}", ("or", ("or", ("next", FAST), ("next", SLOW)), FAST)),
    ],
)
def test_operators(formula: Callable[[str], object], condition: str, expected: object) -> None:
    """The formula is what was written, operands in twos; what is free of time is one atom."""
    assert formula(condition) == expected


def test_equal_atoms_are_watched_once(compiled: Compiled) -> None:
    """Both formulas look at one rule, and a formula with one atom twice needs no second."""
    scenario = compiled(f"require (next {FAST}) or (eventually {FAST})\n" + END)
    assert [rule.kind for rule in scenario.variants[0].rules].count(RuleKind.WATCH) == 1


def test_draws_are_never_shared(compiled: Compiled) -> None:
    """Each `Range` is another number."""
    atom = "ego.speed > Range(3, 4) m/s"
    scenario = compiled(f"require (next {atom}) or (eventually {atom})\n" + END)
    assert [rule.kind for rule in scenario.variants[0].rules].count(RuleKind.WATCH) == 2


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        (f"eventually ({FAST} and gap < 4 m)", ("eventually", f"{FAST} and gap < 4 m")),
        (f"(eventually {FAST}) and gap < 4 m", ("eventually", FAST)),
        (f"(eventually {FAST}) or gap > 4 m", ("eventually", FAST)),
        (f"gap < 4 m implies (eventually {FAST})", ("eventually", FAST)),
        (f"(eventually {FAST}) implies gap > 4 m", ("not", ("eventually", FAST))),
        (f"gap < 4 m until {FAST}", ("eventually", FAST)),
        (f"gap > 4 m until (next {FAST})", ("next", FAST)),
    ],
)
def test_known_parts_are_left_out(compiled: Compiled, condition: str, expected: object) -> None:
    """What is the same in every run decides now."""
    scenario = compiled(f"gap = 3 m\nrequire {condition}\n" + END)
    assert shape(scenario.temporals[0].formula, scenario) == expected


def test_next_holds_at_no_last_sample(compiled: Compiled) -> None:
    """`next` of what is known to be true still asks for a next sample."""
    scenario = compiled("gap = 3 m\nrequire next gap < 4 m\n" + END)
    assert scenario.temporals[0].formula.op == TemporalOp.NEXT


def test_names_may_stand_below(compiled: Compiled) -> None:
    """A temporal requirement sees the whole file, as `terminate when` does."""
    scenario = compiled("require always (distance to other) > 2 m\nother = new Car behind ego by 9 m\n" + END)
    condition = scenario.variants[0].rules[0].condition
    assert condition is not None
    assert [each.name for each in scenario.variants[0].requirements] == [
        "always (distance to other) > 2 m (at the start)"
    ]


def test_it_looks_at_the_moment(compiled: Compiled) -> None:
    """Speeds are those of the sample."""
    scenario = compiled(f"require eventually {FAST}\n" + END)
    condition = scenario.variants[0].rules[0].condition
    assert isinstance(condition, ir.Apply)
    speed = condition.arguments[1]
    assert isinstance(speed, ir.Apply)
    assert (speed.op, speed.immediates) == (Op.STATE, (0, int(State.SPEED)))


def test_abort_comes_before_terminate(compiled: Compiled) -> None:
    """Where both are true in one sample, the requirement is broken."""
    scenario = compiled(f"terminate when {SLOW}\nrequire always {FAST}\n" + END)
    assert [rule.kind for rule in scenario.variants[0].rules] == [RuleKind.ABORT, RuleKind.TERMINATE]


def test_variants_share_the_formula(compiled: Compiled) -> None:
    """The structure is the file's, the conditions are the variant's."""
    text = "goal = Uniform(*intersection.incomingLanes)\nrequire eventually ego in goal\n" + END
    scenario = compiled(text)
    assert len(scenario.variants) == 4
    assert len(scenario.temporals) == 1
    rules = [[(rule.name, rule.kind) for rule in variant.rules] for variant in scenario.variants]
    assert all(each == rules[0] for each in rules)
    assert len({str(variant.rules[0].condition) for variant in scenario.variants}) > 1


def test_what_differs_between_variants_is_not_known(compiled: Compiled) -> None:
    """A condition true in one variant and false in another stays in the formula."""
    text = "goal = Uniform(*network.lanes)\nrequire eventually (goal is lane or ego.speed > 9 m/s)\n" + END
    scenario = compiled(text)
    assert len(scenario.temporals) == 1


def test_implies_of_one_moment_is_about_the_scene(compiled: Compiled) -> None:
    """Without another temporal operator a requirement is tested when the scene is drawn."""
    scenario = compiled("v = Range(1, 9) m/s\nrequire v > 6 m/s implies (distance to intersection) > 9 m\n")
    assert len(scenario.variants[0].requirements) == 1
    assert scenario.variants[0].rules == ()


@pytest.mark.parametrize("text", ["require gap > 2 m\n", "require always gap > 2 m\n"])
def test_pinned_params_are_nobodys_slip(said: Said, text: str) -> None:
    """A condition that `-p` decides gets no warning."""
    assert said(f"param GAP = Range(1, 9) m\ngap = GAP\n{text}" + END, {"GAP": "3"}) == []


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        (f"require eventually {FAST}\n", ["SCN464"]),
        (f"require eventually {FAST}\nsimulation(max_time=9 s)\n", []),
        (f"require always {FAST}\n", []),
        (f"require[0.3] eventually {FAST}\n" + END, ["SCN461"]),
    ],
)
def test_advice(said: Said, text: str, codes: list[str]) -> None:
    """What is hardly meant is said, and nothing else."""
    assert said(text) == codes
