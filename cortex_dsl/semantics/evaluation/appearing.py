"""Objects that appear during a run: `new` in a behavior or in `compose`.

Such an object is an actor of the program like all others, absent until its `new` runs. Its place and its speed are
computed at that moment, and its other properties with the scene. A `new` in a loop has as many actors as
`simulation(late=N)` says; each time, the next of them appears. Where its outline touches that of another object, or it
breaks what its specifiers require, the run is aborted.
"""

from collections.abc import Callable, Sequence

from cortex_dsl import ir
from cortex_dsl.semantics.errors.names import NOT_SUPPORTED
from cortex_dsl.semantics.errors.runs import TOO_MANY_APPEAR
from cortex_dsl.semantics.evaluation import geometry
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import Actor, Pose
from cortex_dsl.semantics.quantities.algebra import Term, box_distance, region_contains_box
from cortex_dsl.source import Span
from cortex_dsl.syntax import nodes
from engine.tables import ROAD_REGION
from engine.vocabulary import RuleKind

MOST = 64
"""Maximum number of objects of a file that appear."""
DEEPEST = 8
"""Longest chain of objects of which each appears by the behavior of the one before, which may be the same behavior."""

Make = Callable[[], tuple[Actor, Pose, Term]]
"""Makes an actor, with its pose and its speed at the present sample."""


def appear(ev: Evaluator, node: nodes.New, make: Make, *, on_road: bool) -> Actor:
    """Write the acts by which objects of a `new` appear; return the object, or the last of several."""
    built = ev.run.built
    assert built.appearing is not None
    if not ev.moment.repeated:
        actor, block = _entering(ev, node, make, on_road=on_road)
        built.appearing.extend(block)
        return actor
    count = ev.file.settings.late
    counter = ev.run.new_local()
    made = [_entering(ev, node, make, on_road=on_road) for _ in range(count)]
    name = f"at most {count} objects of line {ev.facts.line(node.span)} appear, by `late` of `simulation`"
    block: ir.Block = (ir.Demand(node.span, ev.algebra.truth(False), _rule(ev, node.span, name)),)
    for number in reversed(range(count)):
        is_next = ev.algebra.local(counter) <= number + 0.5
        block = (ir.Branch(node.span, is_next, made[number][1], block),)
    built.appearing.extend((*block, ir.SetLocal(node.span, counter, ev.algebra.local(counter) + 1.0)))
    return made[-1][0]


def _entering(ev: Evaluator, node: nodes.New, make: Make, *, on_road: bool) -> tuple[Actor, ir.Block]:
    """Return an actor, and the acts that let it enter, with the conditions that its specifiers add."""
    built, span = ev.run.built, node.span
    required = len(built.requirements)
    actor, pose, speed = make()
    conditions = [(each.name, each.condition) for each in built.requirements[required:]]
    del built.requirements[required:]
    box = geometry.outline_of(ev, actor)
    if on_road:
        conditions.append((f"{actor.name} appears on the road", region_contains_box(float(ROAD_REGION), box)))
    if not actor.properties.get("allowCollisions", False):
        conditions += list(_free(ev, actor, box))
    if ev.moment.scenario is None:
        # The watched condition keeps a run going while the ego is alone: the object may still appear.
        place = Span(span.start, span.start + actor.index)
        ev.file.run.rule(place, f"{actor.name} is there", RuleKind.WATCH)
        built.rule_conditions[place, RuleKind.WATCH] = geometry.is_present(ev, actor)
    demands = (ir.Demand(span, holds, _rule(ev, span, name)) for name, holds in conditions)
    return actor, (ir.Enter(span, actor.index, (pose.x, pose.y, pose.heading, speed)), *demands)


def _free(ev: Evaluator, actor: Actor, box: Term) -> list[tuple[str, Term]]:
    """Return, for each other object, the condition that it does not touch an actor that appears."""
    found: list[tuple[str, Term]] = []
    for other in geometry.others(ev, actor):
        apart = box_distance(box, geometry.outline_of(ev, other)) > 0.0
        name = f"the place where {actor.name} appears is free of {other.name}"
        found.append((name, ~geometry.is_present(ev, other) | apart))
    return found


def _rule(ev: Evaluator, span: Span, name: str) -> int:
    """Return the rule that aborts the run; of several at one place, each has a place of its own."""
    taken = ev.run.built.late_rules
    number = taken.setdefault((span, name), len([each for each, _ in taken if each == span]))
    return ev.file.run.rule(Span(span.start, span.start + number), name, RuleKind.ABORT)


def refuse_drawn_place(ev: Evaluator, drawn: int, span: Span) -> None:
    """Refuse a place of an object that appears if it is drawn from a region; `drawn`: number of draws before it."""
    if ev.run.decisions.draw_count > drawn:
        raise NOT_SUPPORTED.mistake(
            span,
            what="an object that appears during the run cannot have a place that is drawn from a region",
            reason="such places are drawn with the scene",
            cure="draw the place before the run, as in `spot = new Point on road` at the top level",
        )


def check_count(span: Span, late: Sequence[Actor]) -> None:
    """Refuse more objects than a file may let appear."""
    if len(late) >= MOST:
        raise TOO_MANY_APPEAR.mistake(span, limit=f"{MOST} objects")
