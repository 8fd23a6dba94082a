"""What a file expects, and what it lets a search make large or small: formulas, numbers, and what is said of them."""

from collections.abc import Callable

import pytest

from cortex_dsl import ir
from engine.opcodes import Op
from engine.vocabulary import Reducer, RuleKind, Sense, TemporalOp

Compiled = Callable[..., ir.Scenario]
Said = Callable[..., list[str]]
END = "terminate after 9 s\n"
OTHER = "other = new Car ahead of ego by 12 m\n"


def atom(scenario: ir.Scenario, formula: ir.Formula) -> tuple[ir.Expr, ir.Expr]:
    """The condition of the first atom of a formula, and how far it holds."""
    while formula.op != TemporalOp.ATOM:
        formula = formula.operands[0]
    rules = scenario.variants[0].rules
    condition, number = rules[formula.watch].condition, rules[formula.margin].condition
    assert condition is not None
    assert number is not None
    return condition, number


@pytest.fixture
def expected(compiled: Compiled) -> Callable[[str], tuple[ir.Expr, ir.Expr]]:
    """The first atom of an expectation, as condition and number."""

    def of(condition: str) -> tuple[ir.Expr, ir.Expr]:
        scenario = compiled(f"{OTHER}expect {condition}\n{END}")
        (objective,) = scenario.objectives
        assert objective.formula is not None
        return atom(scenario, objective.formula)

    return of


def test_an_expectation_rejects_nothing(compiled: Compiled) -> None:
    """No requirement of the start, no rule that aborts: its atoms are watched."""
    scenario = compiled(f'expect always ego.speed < 2 m/s as "slow"\n{END}')
    (objective,) = scenario.objectives
    assert (objective.sense, objective.name, objective.line) == (Sense.EXPECT, "slow", 4)
    assert scenario.variants[0].requirements == ()
    assert [rule.kind for rule in scenario.variants[0].rules] == [RuleKind.WATCH, RuleKind.WATCH]
    assert scenario.temporals == ()


def test_nothing_is_folded(compiled: Compiled) -> None:
    """What is known to hold still says how far it does."""
    scenario = compiled(f"gap = 3 m\nexpect (always ego.speed > 1 m/s) and gap > 2 m\n{END}")
    formula = scenario.objectives[0].formula
    assert formula is not None
    assert (formula.op, len(formula.operands)) == (TemporalOp.AND, 2)
    _, number = atom(scenario, formula.operands[1])
    assert isinstance(number, ir.Literal)
    assert number.value == 1.0


@pytest.mark.parametrize(
    ("condition", "operation"),
    [
        ("always ego.speed < 3 m/s", Op.SUB),
        ("always relative heading of ego from other < 9 deg", Op.DIV),
        ("always ego in road", Op.REGION_BOX_DEPTH),
        ("always ego.position in road", Op.REGION_DEPTH),
        ("always ego can see other", Op.SELECT),
        ("always not self.collided", Op.NEG),
        ("always (ego.speed < 3 m/s and other.speed < 3 m/s)", Op.MIN),
        ("always (ego.speed < 3 m/s or other.speed < 3 m/s)", Op.MAX),
        ("always ego.speed == other.speed", Op.NEG),
        ("always ego.speed != other.speed", Op.ABS),
        ("always timeToCollision(ego) > timeToCollision(other)", Op.SELECT),
    ],
)
def test_every_condition_has_a_number(
    expected: Callable[[str], tuple[ir.Expr, ir.Expr]], condition: str, operation: Op
) -> None:
    """Margins in comparable units, depths in regions, 1 and -1 for bare truths."""
    _, number = expected(condition)
    assert isinstance(number, ir.Apply)
    assert number.op == operation


def test_a_tenth_of_a_radian_counts_as_a_metre(expected: Callable[[str], tuple[ir.Expr, ir.Expr]]) -> None:
    """Angles are divided by 0.1 rad."""
    _, number = expected("always relative heading of ego from other < 9 deg")
    assert isinstance(number, ir.Apply)
    unit = number.arguments[1]
    assert isinstance(unit, ir.Literal)
    assert unit.value == 0.1


@pytest.mark.parametrize(
    "condition",
    ["(minimum distance from ego to other) > 0 m", "(minimum distance to other) > 0 m", "not (other intersects self)"],
)
def test_contact_is_a_distance_of_nothing(expected: Callable[[str], tuple[ir.Expr, ir.Expr]], condition: str) -> None:
    """Where the ego has touched the other, the distance of their outlines is 0, whatever rounding says."""
    holds, _ = expected(f"always {condition}")
    touches = [part for part in walk(holds) if isinstance(part, ir.Apply) and part.op == Op.TOUCHES]
    assert [part.immediates for part in touches] == [(1,)]


def walk(expression: ir.Expr) -> list[ir.Expr]:
    return [expression, *(e for a in getattr(expression, "arguments", ()) for e in walk(a))]


def test_requirements_see_no_contact(compiled: Compiled) -> None:
    """`require always` keeps its meaning: nothing in it asks for contact."""
    scenario = compiled(f"{OTHER}require always (minimum distance from ego to other) > 0 m\n{END}")
    conditions = [rule.condition for rule in scenario.variants[0].rules if rule.condition is not None]
    assert not any(isinstance(part, ir.Apply) and part.op == Op.TOUCHES for c in conditions for part in walk(c))


def test_a_number_of_the_run(compiled: Compiled) -> None:
    """Reducers and results are readings, and the rest is arithmetic on them."""
    scenario = compiled(f'{OTHER}maximize largest(ego.speed) * 2 - 1 s * total(ego.speed) / 4 s**2 as "n"\n{END}')
    (objective,) = scenario.objectives
    assert (objective.sense, objective.dimension) == (Sense.MAXIMIZE, ir.Dimension(length=1, time=-1))
    assert [reading.kind for reading in scenario.readings] == [Reducer.LARGEST, Reducer.TOTAL]
    assert scenario.variants[0].objectives[0] is not None
    assert scenario.variants[0].local_count == 2


def test_results_by_name(compiled: Compiled) -> None:
    """A result needs no reducer; a name of the file's own comes first."""
    scenario = compiled(f"{OTHER}minimize min_distance\n{END}")
    assert scenario.readings == (ir.Reading(Reducer.RESULT, result="min_distance"),)
    assert scenario.objectives[0].name == "min_distance"
    assert compiled(f"{OTHER}min_distance = 3 m\nminimize min_distance\n{END}").readings == ()


def test_variants_share_readings(compiled: Compiled) -> None:
    """They are numbered alike, whatever is chosen."""
    text = f"goal = Uniform(*intersection.incomingLanes)\nminimize least(distance from ego to goal)\n{END}"
    scenario = compiled(text)
    assert len(scenario.variants) == 4
    assert len(scenario.readings) == 1
    assert all(variant.objectives[0] is not None for variant in scenario.variants)


@pytest.mark.parametrize("word", ["expect", "maximize", "minimize"])
def test_the_words_stay_names(alone: Compiled, word: str) -> None:
    """Where they are assigned or called."""
    text = f"map intersection()\n{word} = lambda x: x + 1 m\nego = new Car on road, with width {word}(1 m)\n"
    assert alone(text + f"require {word}(2 m) < 4 m\n").objectives == ()


@pytest.mark.parametrize("value", ["(largest(ego.speed))", "-largest(ego.speed)", "largest(ego.speed)"])
def test_what_follows_the_words(compiled: Compiled, value: str) -> None:
    """A bracket or a sign may come at once, as after `record`."""
    assert len(compiled(f"maximize {value}\n{END}").objectives) == 1
    assert len(compiled(f"maximize{value if value[0] == '(' else ' ' + value}\n{END}").objectives) == 1


@pytest.mark.parametrize(
    ("text", "codes"),
    [
        ("gap = 3 m\nexpect always gap < 4 m\n", ["SCN490"]),
        ("gap = 3 m\nexpect always gap > 4 m\n", ["SCN491"]),
        ("expect not self.collided\n", ["SCN497"]),
        ("param V = Range(0, 1)\nexpect V < 0.9\n", []),
        ("expect ego.speed < 2 m/s or ego in road\n", ["SCN497"]),
        ("expect (eventually ego.speed < 2 m/s) or ego in road\n", []),
        ('expect always ego.speed < 2 m/s as "risk"\n', ["SCN492"]),
        ('expect always ego.speed < 2 m/s as "two\\nlines"\n', ["SCN498"]),
        ('maximize largest(ego.speed) as "red \\x1b[31m"\n', ["SCN498"]),
        ("maximize ego.speed\n", ["SCN493"]),
        ("require always not ego.collided\n", ["SCN494"]),
        (OTHER + "expect always not other.collided\n", ["SCN494"]),
        ("minimize min_distance\n", ["SCN495"]),
        ("expect always ego.speed < 2 m\n", ["SCN302"]),
        ("maximize largest(ego.speed) + 1 m\n", ["SCN302"]),
        ("maximize largest(ego)\n", ["SCN303"]),
        ("maximize largest()\n", ["SCN308"]),
        ("maximize biggest(ego.speed)\n", ["SCN201"]),
        ("record largest(ego.speed)\n", ["SCN201"]),
        ("require self.speed > 1 m/s\n", ["SCN432"]),
        ("expect always self.speed > 1 m/s\n", []),
        ("expect eventually ego.speed < 1 m/s as x\nexpect always ego.speed > 1 m/s as x\n", ["SCN210"]),
    ],
)
def test_what_is_said(said: Said, text: str, codes: list[str]) -> None:
    """Each slip has its code."""
    assert said(text + END) == codes


def test_a_pinned_param_is_nobodys_slip(said: Said) -> None:
    """A condition that `-p` decides gets no warning."""
    assert said(f"param GAP = Range(1, 9) m\nexpect always GAP > 2 m\n{END}", {"GAP": "3"}) == []


def test_without_an_end_there_is_a_hint(said: Said) -> None:
    """What must come true some day comes true within the usual time."""
    assert said("expect eventually ego.speed < 1 m/s\n") == ["SCN464"]


def test_a_scenario_that_starts_later_has_none(said: Said) -> None:
    """Expectations are of the whole run."""
    text = (
        "scenario Sub():\n    setup:\n        expect always ego.speed > 1 m/s\n\n"
        "scenario Main():\n    setup:\n        pass\n    compose:\n        do Sub()\n"
    )
    assert "SCN657" in said(text)
