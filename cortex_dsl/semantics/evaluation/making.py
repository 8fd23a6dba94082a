"""The properties of an object while it is made: those given, then the defaults of its classes, then of its kind.

Each is stored as a value of the right kind, inside its legal range.
"""

import difflib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from cortex_dsl.diagnostics import Label
from cortex_dsl.semantics.errors.names import (
    CLASS_ABOVE,
    NOT_SUPPORTED,
    UNKNOWN_ATTRIBUTE,
    UNKNOWN_CLASS,
    UNKNOWN_PROPERTY,
)
from cortex_dsl.semantics.errors.problems import Mistake
from cortex_dsl.semantics.errors.runs import OBSTACLE_BEHAVIOUR
from cortex_dsl.semantics.errors.scene import FASTER_THAN_TOP, NEARLY_A_PROPERTY, PROPERTY_CYCLE, PROPERTY_TWICE
from cortex_dsl.semantics.errors.values import CANNOT_ASSIGN, WRONG_KIND
from cortex_dsl.semantics.evaluation import attributes, geometry, numbers
from cortex_dsl.semantics.evaluation.attributes import property_value
from cortex_dsl.semantics.evaluation.calls import as_behaviour
from cortex_dsl.semantics.evaluation.functions import known_truth
from cortex_dsl.semantics.evaluation.levels import lanes_of_level
from cortex_dsl.semantics.evaluation.placements import Placement
from cortex_dsl.semantics.evaluation.ranges import in_range, within
from cortex_dsl.semantics.model.areas import Area
from cortex_dsl.semantics.model.context import Evaluator
from cortex_dsl.semantics.model.values import POISON, ClassValue, Pose, Quantity, Unfinished, Value, Vector
from cortex_dsl.semantics.model.wording import kind_name, shown
from cortex_dsl.semantics.names.properties import (
    ACTOR_KINDS,
    FLAGS,
    IGNORED,
    LOW,
    MEASURED,
    MODEL_FIELDS,
    PLACED,
    PLACES,
    PROPERTIES,
    SCENIC_ONLY,
    Domain,
    all_properties,
)
from cortex_dsl.semantics.names.tree import unit_word
from cortex_dsl.semantics.quantities.algebra import Term
from cortex_dsl.semantics.quantities.units import SPEED, UNITS
from cortex_dsl.source import Span
from cortex_dsl.spelling import did_you_mean
from cortex_dsl.syntax import nodes
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind

# -- values of properties ----------------------------------------------------------------------------------------------


def refuse_scenic_only(name: str, span: Span, kind: str) -> None:
    """Refuse a property that means something to Scenic and nothing here, where any other name may be the file's own."""
    if name in SCENIC_ONLY:
        raise UNKNOWN_PROPERTY.mistake(span, kind=kind, name=name, suggestion=SCENIC_ONLY[name])


def checked(ev: Evaluator, name: str, value: Value, span: Span, *, may_act: bool) -> Value:
    """A value of a property, as it is stored."""
    if name in IGNORED:
        return None
    if name in FLAGS:
        return _flag(ev, name, value, span, may_act=may_act)
    if name not in PROPERTIES:
        return value
    spec = PROPERTIES[name]
    if spec.truth:
        return numbers.truth(ev, value, span)
    expr = numbers.adopt(ev, value, spec.dimension, span, f"`{name}`")
    return within(ev, expr, spec, span, f"`{name}`")


def _flag(ev: Evaluator, name: str, value: Value, span: Span, *, may_act: bool) -> Value:
    if name == "behavior":
        return _behaviour(value, span, may_act=may_act)
    if name in ("allowCollisions", "requireVisible"):
        return known_truth(ev, value, span, f"`{name}`")
    if name in MEASURED:
        return _measured(ev, MEASURED[name], value, span)
    if name == "level":
        return lanes_of_level(ev, value, span)
    if name == "name" and not isinstance(value, str):
        raise WRONG_KIND.mistake(span, what="`name`", expected="text", actual=kind_name(value), cure="")
    return value


def _measured(ev: Evaluator, domain: Domain, value: Value, span: Span) -> Quantity:
    number = numbers.adopt(ev, value, domain.dimension, span, domain.name)
    return Quantity(in_range(ev, number, domain, span), domain.dimension)


def _behaviour(value: Value, span: Span, *, may_act: bool) -> Value:
    if value is None:
        return None
    behaviour = as_behaviour(value, span)
    if behaviour is None:
        raise WRONG_KIND.mistake(
            span, what="`behavior`", expected="a behavior", actual=kind_name(value), cure="as in `FollowLaneBehavior()`"
        )
    if not may_act:
        raise OBSTACLE_BEHAVIOUR.mistake(span)
    return behaviour


SCENIC_SIZES: Mapping[ActorKind, Mapping[str, float]] = {
    ActorKind.CAR: {"length": 4.5, "width": 2.0},
    ActorKind.PEDESTRIAN: {"length": 0.75, "width": 0.75},
}
"""Outlines in Scenic's driving model, which files with its `model` line have [m]."""
SLIP = 0.8
"""Similarity from which a property of a class counts as a misspelling."""


def own_class(ev: Evaluator, name: str) -> ClassValue | None:
    return value if isinstance(value := ev.find(name), ClassValue) else None


def define(ev: Evaluator, node: nodes.ClassDefinition) -> ClassValue:
    """A class of the file's own; without a base it is a plain object that never moves by itself."""
    seen: dict[str, Span] = {}
    for default in node.properties:
        if default.name in seen:
            first = Label(seen[default.name], "first here")
            raise PROPERTY_TWICE.mistake(default.name_span, name=default.name, secondary=(first,))
        seen[default.name] = default.name_span
        if default.name in attributes.RUNNING_ATTRIBUTES:
            reason = "the run sets it, step by step"
            raise CANNOT_ASSIGN.mistake(default.name_span, name=default.name, reason=reason)
    bases = _bases(ev, node)
    kind = bases[0].kind if bases else ACTOR_KINDS[node.base or "Object"]
    for default in node.properties:
        refuse_scenic_only(default.name, default.name_span, f"the class `{node.name}`")
    made = ClassValue(node, kind, bases, ev.scopes, ev.home)
    _warn_of_slips(ev, made)
    return made


def _bases(ev: Evaluator, node: nodes.ClassDefinition) -> tuple[ClassValue, ...]:
    if node.base is None:
        return ()
    if (base := own_class(ev, node.base)) is not None:
        return (base, *base.bases)
    span = node.base_span or node.span
    if node.base in PLACES:
        what = f"a class cannot be made from `{node.base}`"
        raise NOT_SUPPORTED.mistake(span, what=what, reason="places have no sizes", cure="use `Object`")
    if node.base not in ACTOR_KINDS:
        known = {*ACTOR_KINDS, *(name for name in ev.known_names() if own_class(ev, name) is not None)}
        raise UNKNOWN_CLASS.mistake(span, name=node.base, suggestion=did_you_mean(node.base, known) or CLASS_ABOVE)
    return ()


def _warn_of_slips(ev: Evaluator, made: ClassValue) -> None:
    inherited = {d.name for base in made.bases for d in base.node.properties}
    for default in made.node.properties:
        if default.name in (*all_properties(), *PLACED) or default.name in inherited:
            continue
        if match := difflib.get_close_matches(default.name, (*PROPERTIES, *FLAGS, *inherited), 1, SLIP):
            ev.report(NEARLY_A_PROPERTY.at(default.name_span, name=default.name, match=match[0]))


@dataclass
class ObjectBuilder:
    """An object under construction. Each property is evaluated at its first use."""

    ev: Evaluator
    kind: ActorKind
    own: ClassValue | None
    builtin: str | None
    """The class of the language that the object is of, or that its own class is made from."""
    given: Sequence[nodes.With]
    posed: Callable[[], Pose] | None = None
    values: dict[str, Value] = field(default_factory=dict)
    pending: dict[str, Span] = field(default_factory=dict)
    """Properties under evaluation, with the place of their use."""
    _pose: Pose | None = None

    def __post_init__(self) -> None:
        self.classes = () if self.own is None else (self.own, *self.own.bases)
        self.defaults: dict[str, tuple[ClassValue, nodes.PropertyDefault]] = {}
        for each in reversed(self.classes):
            self.defaults |= {default.name: (each, default) for default in each.node.properties}

    @property
    def may_act(self) -> bool:
        """Return whether it may have a behaviour."""
        return self.plain or self.kind is not ActorKind.OBSTACLE

    def declares(self, name: str) -> bool:
        return name in self.defaults

    def has(self, name: str) -> bool:
        """Return whether the object or its class gives a property."""
        return name in self.defaults or any(each.property == name for each in self.given)

    def properties(self) -> dict[str, Value]:
        """Return all properties: first the given ones in their order, then the defaults.

        Raises:
            Mistake: one of them is wrong; all wrong ones are reported.
        """
        self.check_doubles()
        results = [self.ev.tolerate(lambda name=name: self.get(name)) for name in self._names()]
        if any(result is POISON for result in results):
            raise Mistake
        self._check_speed()
        return self.values

    def _check_speed(self) -> None:
        """Check that the object starts no faster than its top speed; if unbounded, require it of the scene."""
        speed, top = self.ev.interval(self.number("speed")), self.ev.interval(self.number("topSpeed"))
        if not all(map(math.isfinite, (*speed, *top))) or speed[1] <= top[0] + numbers.ROUNDING * (1.0 + top[0]):
            return
        places = {name: default.value.span for name, (_, default) in self.defaults.items()}
        places |= {each.property: each.value.span for each in self.given}
        raise FASTER_THAN_TOP.mistake(
            places["speed" if "speed" in places else "topSpeed"],
            may="is" if speed[0] == speed[1] else "may become",
            actual=shown(speed[1], SPEED),
            name=self.own.node.name if self.own else self.kind.name.capitalize(),
            top=shown(top[0], SPEED),
            reason="" if speed[0] == speed[1] else "it is random or searched",
            cure=shown(math.ceil(speed[1]), SPEED),
        )

    def check_doubles(self) -> None:
        seen: dict[str, Span] = {}
        for with_ in self.given:
            if with_.property in seen:
                first = Label(seen[with_.property], "first here")
                raise PROPERTY_TWICE.mistake(with_.property_span, name=with_.property, secondary=(first,))
            seen[with_.property] = with_.property_span

    def _names(self) -> Iterator[str]:
        yield from (with_.property for with_ in self.given)
        yield from (name for name in self.defaults if name not in PLACED)
        yield from ("speed", *MODEL_FIELDS)

    def get(self, name: str, span: Span | None = None) -> Value:
        """A property as it is stored: a number of the object's kind is a bare expression."""
        if name not in self.values:
            with_ = next((each for each in self.given if each.property == name), None)
            with self._asking(name, span):
                if with_ is not None:
                    self.values[name] = self._given(with_)
                elif name in self.defaults:
                    self.values[name] = self._default(name)
                else:
                    self.values[name] = self._of_kind(name)
        return self.values[name]

    def _asking(self, name: str, span: Span | None) -> "_Asking":
        if name in self.pending:
            chain = [*list(self.pending)[list(self.pending).index(name) :], name]
            default = self.defaults[name][1] if name in self.defaults else None
            place = span or (default.span if default else next(iter(self.pending.values())))
            raise PROPERTY_CYCLE.mistake(place, name=name, cycle=" -> ".join(chain))
        return _Asking(self.pending, name, span or Span(0, 0))

    # -- where it is -------------------------------------------------------------------------------------------------

    def pose(self, span: Span) -> Pose:
        if self._pose is None:
            assert self.posed is not None
            with self._asking("position", span):
                self._pose = self.posed()
            self.posed = None  # which knows this object in turn
        return self._pose

    def default_place(self) -> Placement:
        """Return the default position of the class."""
        owner, default = self.defaults["position"]
        value = self._evaluator(owner).evaluate(default.value)
        point = geometry.position(self.ev, value, default.value.span, "the default of `position`")
        pose = geometry.pose_of(self.ev, value)
        return Placement(point, None) if pose is None else Placement(point, pose.heading, lane=pose.lane)

    def lies_anywhere(self) -> bool:
        """Return whether it may lie off the road."""
        return self.has("regionContainedIn") and (
            self.get("regionContainedIn") is None or isinstance(self.get("regionContainedIn"), Area)
        )

    def default_heading(self, point: Vector) -> Term | None:
        """Return the default heading of the class [rad]; None if it has none."""
        if "heading" not in self.defaults:
            return None
        owner, default = self.defaults["heading"]
        value = self._evaluator(owner).evaluate(default.value)
        return geometry.heading_at(self.ev, value, point, default.value.span)

    # -- values ------------------------------------------------------------------------------------------------------

    def _given(self, node: nodes.With) -> Value:
        name = node.property
        if not (name in all_properties() or name in self.defaults or self._is_own(name)):
            raise UNKNOWN_PROPERTY.mistake(
                node.property_span,
                kind=self._called,
                name=name,
                suggestion=did_you_mean(name, {*all_properties(), *self.defaults}) or SCENIC_ONLY.get(name, ""),
            )
        refuse_scenic_only(name, node.property_span, self._called)
        with self.ev.naming(name):
            value = self.ev.evaluate(node.value)
        if name == "age" and not (
            self._walks or self.plain or {name} & (self.ev.facts.attributes_read | {*self.defaults})
        ):
            reason = "only a `Pedestrian` has an age"
            raise UNKNOWN_PROPERTY.mistake(node.property_span, kind=self._called, name=name, suggestion=reason)
        if name == "age" and not self._walks:
            return value
        return checked(self.ev, name, self._adopted(name, value), node.value.span, may_act=self.may_act)

    @property
    def _walks(self) -> bool:
        return self.kind is ActorKind.PEDESTRIAN

    @property
    def _called(self) -> str:
        """Return its class with an article, for messages."""
        name = self.own.node.name if self.own else self.kind.name.capitalize()
        return f"{'an' if name[0].lower() in 'aeio' else 'a'} {name}"

    def _is_own(self, name: str) -> bool:
        """Return whether an undeclared property belongs to the file and is no misspelling.

        It is set on an `Object`, or the file reads it.
        """
        if not (self.plain or name in self.ev.facts.attributes_read) or name in attributes.RUNNING_ATTRIBUTES:
            return False
        return not difflib.get_close_matches(name, (*all_properties(), *self.defaults), 1, SLIP)

    @property
    def plain(self) -> bool:
        """Return whether it is an `Object`, or of a class of the file without another base."""
        return self.builtin in (None, "Object")

    def _adopted(self, name: str, value: Value) -> Value:
        """A bare number takes the unit of the property's default."""
        if name in PROPERTIES or name not in self.defaults or not isinstance(value, Quantity):
            return value
        word = unit_word(self.defaults[name][1].value)
        if value.dimension is not None or word not in UNITS:
            return value
        return Quantity(value.expr, UNITS[word].dimension)

    def _default(self, name: str) -> Value:
        owner, default = self.defaults[name]
        with self.ev.naming(name):
            value = self._evaluator(owner).evaluate(default.value)
        if name == "age" and not self._walks:
            return value
        return checked(self.ev, name, value, default.value.span, may_act=self.may_act)

    def _evaluator(self, owner: ClassValue) -> Evaluator:
        own = {"self": Unfinished(self._attribute)}
        return self.ev.at_home(owner.home).within((own, *owner.scopes))

    def _attribute(self, name: str, span: Span) -> Value:
        """`self.name` in a default."""
        if name in attributes.POSE_ATTRIBUTES:
            return attributes.get(self.ev, self.pose(span), name, span)
        known = {*PROPERTIES, *FLAGS, *self.defaults}
        if name not in known:
            raise UNKNOWN_ATTRIBUTE.mistake(
                span,
                kind=self._called,
                name=name,
                suggestion=did_you_mean(name, known),
            )
        return property_value(self.get(name, span), name)

    def _of_kind(self, name: str) -> Value:
        """The default of its kind; a longer car has its axles further apart."""
        algebra, model = self.ev.algebra, MODELS[self.kind]
        if name not in MODEL_FIELDS:
            return algebra.literal(0.0) if name == "speed" else None
        if name == "fixed":
            return self.number("mass") > model.fixed_above
        if name == "occluding" and self.ev.facts.from_scenic:
            return algebra.truth(True)  # as in Scenic, where all objects do
        if name == "occluding" and self.builtin in LOW:
            return algebra.truth(False)
        default: Term = algebra.literal(float(getattr(model, MODEL_FIELDS[name])))
        scenic = SCENIC_SIZES.get(self.kind, {}) if self.ev.facts.from_scenic else {}
        if name in scenic:
            return algebra.literal(scenic[name])
        if name not in ("wheelbase", "rearToCenter"):
            return default
        own_length = bool(scenic) or "length" in self.defaults or any(each.property == "length" for each in self.given)
        return default * (self.number("length") / model.length) if own_length else default

    def number(self, name: str) -> Term:
        value = self.get(name)
        assert isinstance(value, Term)
        return value


@dataclass
class _Asking:
    """While a property is worked out, asking for it again is a cycle."""

    pending: dict[str, Span]
    name: str
    span: Span

    def __enter__(self) -> None:
        self.pending[self.name] = self.span

    def __exit__(self, *_: object) -> None:
        del self.pending[self.name]
