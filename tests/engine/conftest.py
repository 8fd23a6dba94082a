"""Programs made by hand, without the language: step code written with named operands, scenes written as columns."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from engine import batch
from engine.config import SimulationConfig
from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.outcomes import Outcomes
from engine.program import ParamSpace, Program, Rule, Settings, VariantLabel
from engine.road import Network, build_network, road_tables
from engine.scenes import Scenes
from engine.tables import CodeTables, RoadTables
from engine.vehicles import MODELS
from engine.vocabulary import ActorKind, Column, Command, ManeuverType, RuleKind, TemporalOp


@dataclass(frozen=True)
class Register:
    """A named operand: ("literal", value), ("local", i), ("temporary", i) or ("value", i)."""

    kind: str
    what: float


def literal(value: float) -> Register:
    return Register("literal", float(value))


def local(index: int) -> Register:
    return Register("local", index)


def temporary(index: int) -> Register:
    return Register("temporary", index)


def value(index: int) -> Register:
    """Scene value `index` behind the actors' columns."""
    return Register("value", index)


@dataclass
class Assembler:
    """Writes step code. Integers stand for themselves, strings are labels, registers are named."""

    kinds: Sequence[ActorKind]
    locals: int = 8
    temporaries: int = 16
    blocks: int = 0
    rows: list[tuple[Op, object, tuple[object, ...]]] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    entries: list[str] = field(default_factory=list)
    rules: list[tuple[str, Register] | None] = field(default_factory=list)
    rule_kinds: list[RuleKind] = field(default_factory=list)
    formula: list[tuple[TemporalOp, int, int]] = field(default_factory=list)
    temporals: list[tuple[int, int]] = field(default_factory=list)
    monitors: list[tuple[int, bool]] = field(default_factory=list)
    absent: frozenset[int] = frozenset()
    actor: int = -1

    def label(self, name: str) -> None:
        self.labels[name] = len(self.rows)

    def emit(self, op: Op, destination: object = 0, *operands: object) -> None:
        self.rows.append((op, destination, operands))

    def behaviour(self, actor: int) -> int:
        """Start the code of an actor's behaviour; its main block has the actor's number."""
        self.label(f"main {actor}")
        return actor

    def block(self) -> int:
        """A new block number; main blocks come first."""
        self.blocks += 1
        return len(self.kinds) + self.blocks - 1

    def rule(self, result: Register, kind: RuleKind = RuleKind.TERMINATE) -> int:
        """The number of a rule whose code follows, up to an END; its value is left in `result`."""
        self.label(f"rule {len(self.rules)}")
        self.rules.append((f"rule {len(self.rules)}", result))
        self.rule_kinds.append(kind)
        return len(self.rules) - 1

    def behaviour_rule(self, kind: RuleKind = RuleKind.TERMINATE) -> int:
        """The number of a rule that code triggers, or that is judged when the run is over."""
        self.rules.append(None)
        self.rule_kinds.append(kind)
        return len(self.rules) - 1

    def node(self, op: TemporalOp, a: int, b: int = -1) -> int:
        """A row of a temporal formula."""
        self.formula.append((op, a, b))
        return len(self.formula) - 1

    def temporal(self, root: int) -> int:
        """The rule that aborts a run in which the formula ending in row `root` does not hold."""
        self.temporals.append((root, self.behaviour_rule(RuleKind.ABORT)))
        return self.temporals[-1][1]

    def monitor(self, *, started: bool = True) -> int:
        """Start the code of a monitor; the number of its block."""
        self.label(f"monitor {len(self.monitors)}")
        self.monitors.append((self.block(), started))
        return self.monitors[-1][0]

    def follow(
        self,
        block: int,
        path: object,
        speed: object,
        lateral: object = None,
        progress: int = 0,
        aside: object = None,
    ) -> None:
        """FollowTrajectoryBehavior until the path's end, with `aside` at an offset."""
        again, done = f"again {len(self.rows)}", f"done {len(self.rows)}"
        self.emit(Op.MOVE, local(progress), literal(-1))
        self.label(again)
        if aside is not None:
            self.emit(Op.COMMAND, 0, int(Command.ASIDE), aside)
        self.emit(Op.FOLLOW, local(progress), path, speed, literal(3) if lateral is None else lateral, done)
        self.emit(Op.YIELD, 0, block)
        self.emit(Op.JUMP, 0, again)
        self.label(done)

    def take(self, block: int, command: int, register: object) -> None:
        self.emit(Op.COMMAND, 0, int(command), register)
        self.emit(Op.YIELD, 0, block)

    def attempt(
        self,
        parent: int,
        body: Callable[[int], None],
        *handlers: tuple[Callable[[], Register], Callable[[int], None]],
        end: str | None = None,
    ) -> None:
        """`try: body` with `interrupt when condition: handler`; each writes its code, given its own block.

        A condition leaves its truth in the register that it returns. `abort` is a jump to the label `end`.
        """
        name = f"try {len(self.rows)}"
        end = f"{name} end" if end is None else end
        body_block, blocks = self.block(), [self.block() for _ in handlers]
        self.emit(Op.SET_RESUME, 0, body_block, f"{name} body")
        for block in blocks:
            self.emit(Op.SET_RESUME, 0, block, -1)
        self.label(name)
        self.emit(Op.SET_RESUME, 0, parent, name)
        for block, (condition, _) in reversed([*zip(blocks, handlers, strict=True)]):
            self.emit(Op.JUMP_IF_RUNNING, 0, block, f"{name} enter {block}")
            self.emit(Op.JUMP_UNLESS, 0, condition(), f"{name} skip {block}")
            self.emit(Op.SET_RESUME, 0, block, f"{name} start {block}")
            self.label(f"{name} enter {block}")
            self.emit(Op.RESUME, 0, block)
            self.label(f"{name} skip {block}")
        self.emit(Op.RESUME, 0, body_block)
        self.label(f"{name} body")
        body(body_block)
        self.emit(Op.JUMP, 0, end)
        for block, (_, handler) in zip(blocks, handlers, strict=True):
            self.label(f"{name} start {block}")
            handler(block)
            self.emit(Op.SET_RESUME, 0, block, -1)
            self.emit(Op.JUMP, 0, name)
        self.label(end)

    def program(self, road: RoadTables, extra_values: int = 0) -> Program:
        literals = sorted({o.what for row in self.rows for o in _registers(row)} | {0.0})
        values = len(self.kinds) * len(Column) + extra_values
        starts = {
            "value": len(literals) + len(self.kinds) * len(Column),
            "local": len(literals) + values,
            "temporary": len(literals) + values + self.locals,
        }

        def number(operand: object) -> int:
            if isinstance(operand, str):
                return self.labels[operand]
            if isinstance(operand, Register):
                if operand.kind == "literal":
                    return literals.index(operand.what)
                return starts[operand.kind] + int(operand.what)
            return int(operand)  # type: ignore[arg-type]

        code = [
            [int(op), number(destination), *map(number, operands), *([0] * (4 - len(operands)))]
            for op, destination, operands in self.rows
        ]
        actors = len(self.kinds)
        tables = CodeTables(
            scene_code=_ints(np.zeros((0, 6))),
            step_code=_ints(code).reshape(-1, 6),
            literals=np.array(literals),
            pool=np.zeros(0),
            variant_values=np.zeros((1, 0)),
            variant_template=_ints([0]),
            variant_rejection=_ints([-1]),
            variant_cumulative=np.ones(1),
            group_start=_ints([0, 1]),
            group_gene=_ints([]),
            group_size=_ints([]),
            gene_scale=np.zeros(0),
            requirement_segment=_ints(np.zeros((1, 0, 3))),
            requirement_probability=np.zeros(0),
            output_segment=_ints([[0, 0]]),
            output_register=_ints([[0] * values]),
            road_check=_ints([0] * actors),
            overlap_check=_ints([0] * actors),
            actor_kind=_ints(self.kinds),
            behaviour_entry=_ints([[self.labels.get(f"main {actor}", -1) for actor in range(actors)]]),
            main_block=_ints([range(actors)]),
            rule_segment=_ints(
                [
                    (-1, -1, -1) if rule is None else (self.labels[rule[0]], len(code), number(rule[1]))
                    for rule in self.rules
                ]
            ).reshape(1, -1, 3),
            rule_kind=_ints(self.rule_kinds),
            formula=_ints(self.formula).reshape(-1, 3),
            temporal_root=_ints([root for root, _ in self.temporals]),
            temporal_rule=_ints([rule for _, rule in self.temporals]),
            monitor_entry=_ints([self.labels[f"monitor {i}"] for i in range(len(self.monitors))]).reshape(1, -1),
            monitor_block=_ints([block for block, _ in self.monitors]).reshape(1, -1),
            monitor_started=_ints([started for _, started in self.monitors]),
            actor_present=_ints([actor not in self.absent for actor in range(actors)]),
            margin_segment=_ints(np.zeros((1, 0, 3))),
            sizes=_ints([0, 0, values, starts["temporary"] + self.temporaries, starts["local"], actors + self.blocks]),
        )
        nothing = np.zeros(0)
        return Program(
            name="by hand",
            description="",
            digest="",
            source_text="",
            space=ParamSpace((), (), _ints(()), nothing, nothing, _ints(()), np.zeros((0, 2)), nothing, (), ()),
            actors=tuple(f"actor{i}" for i in range(actors)),
            requirements=(),
            rules=tuple(Rule(f"rule {i}", i, kind) for i, kind in enumerate(self.rule_kinds)),
            variants=(VariantLabel(1.0, (), ()),),
            settings=Settings(),
            code=tables,
            road=road,
            road_spec=RoadSpec(),
            step_lines=_ints(np.zeros(len(code))),
            routes=_ints([[-1] * actors]),
        )


def _registers(row: tuple[Op, object, tuple[object, ...]]) -> list[Register]:
    _, destination, operands = row
    return [o for o in (destination, *operands) if isinstance(o, Register) and o.kind == "literal"]


def _ints(values: Iterable[Any]) -> np.ndarray:
    return np.asarray(values if isinstance(values, np.ndarray) else list(values), dtype=np.int32)


def placed(kind: ActorKind, x: float, y: float, heading: float, speed: float, **changes: float) -> np.ndarray:
    """One actor's block of scene values: the defaults of its kind at a place, with changes by column name."""
    model = MODELS[kind]
    names = {column: column.name.lower() for column in Column}
    columns = np.array([getattr(model, name, 0.0) for name in names.values()], dtype=float)
    for name, number in {"x": x, "y": y, "heading": heading, "speed": speed, **changes}.items():
        columns[Column[name.upper()]] = number
    return columns


def scenes_of(*rows: Sequence[np.ndarray], extra: Sequence[float] = ()) -> Scenes:
    """One scene a row; each row is the `placed` blocks of its actors."""
    values = np.array([np.concatenate([*row, extra]) for row in rows])
    n = len(values)
    keys = np.zeros((n, 6), dtype=np.int64)
    keys[:, 4] = np.arange(n)
    return Scenes(
        genomes=np.zeros((n, 0)),
        keys=keys,
        verdict=np.zeros(n, dtype=np.int32),
        variant=np.zeros(n, dtype=np.int32),
        values=values,
        draws=np.zeros((n, 0)),
        attempts=np.ones(n, dtype=np.int64),
        tested=np.zeros((n, 0), dtype=np.int64),
        failed=np.zeros((n, 0), dtype=np.int64),
        actions=np.zeros((n, 0, 0)),
    )


@dataclass(frozen=True)
class Hand:
    """The tools of this file as one fixture: test modules cannot import from here."""

    network: Network

    literal = staticmethod(literal)
    local = staticmethod(local)
    temporary = staticmethod(temporary)
    value = staticmethod(value)
    placed = staticmethod(placed)
    scenes = staticmethod(scenes_of)

    def assembler(self, *kinds: ActorKind) -> Assembler:
        return Assembler(kinds)

    def road(self) -> RoadTables:
        return road_tables(self.network)

    def outcome(self, program: Program, scenes: Scenes, jobs: int = 1, **settings: float) -> Outcomes:
        """What the batch host makes of all scenes; `settings` are those of `SimulationConfig`."""
        return batch.simulate(program, scenes, replace(SimulationConfig(), **settings), jobs)

    def states(self, program: Program, scenes: Scenes, row: int = 0, **settings: float) -> np.ndarray:
        """Recorded states (samples, actors, len(State)) of one scene."""
        return batch.trajectory(program, scenes, row, replace(SimulationConfig(), **settings)).states

    def route(self, arm: str, turn: ManeuverType) -> int:
        """Path from the border through the junction to the border again."""
        lane = next(lane for lane in self.network.lanes if lane.name == f"{arm}.in.1")
        maneuver = next(m for m in lane.maneuvers if m.type is turn)
        return self.network.paths.join([lane.path, maneuver.connecting_lane.path, maneuver.end_lane.path])

    def on_route(self, path: int, s: float, speed: float, kind: ActorKind = ActorKind.CAR, left: float = 0.0):
        """An actor with its centre at arc length s of a path, `left` of it."""
        pose = self.network.paths.pose(path, s)
        x, y = pose.x - left * np.sin(pose.heading), pose.y + left * np.cos(pose.heading)
        return placed(kind, x, y, pose.heading, speed)


@pytest.fixture(scope="session")
def hand() -> Hand:
    """A four-way junction of single lanes with approaches of 50 m, and tools to write programs on it."""
    return Hand(build_network(RoadSpec()))


@pytest.fixture(scope="session")
def crossing(hand: Hand) -> Program:
    """Two cars on crossing straight paths; the ego brakes (scene value 0) within value 1 and ends the run within 2."""
    return crossing_program(hand, hand.route("south", ManeuverType.STRAIGHT), hand.route("east", ManeuverType.STRAIGHT))


def crossing_program(hand: Hand, ego_path: int, other_path: int) -> Program:
    """The behaviours of the paper's scenario A, with values 3 and 4 as the two target speeds."""
    code = hand.assembler(ActorKind.CAR, ActorKind.CAR)
    terminate = code.behaviour_rule()
    code.rule(temporary(5))
    code.emit(Op.STATE, temporary(0), 0, 0)
    code.emit(Op.STATE, temporary(1), 0, 1)
    code.emit(Op.SUB, temporary(2), temporary(0), value(5))
    code.emit(Op.SUB, temporary(3), temporary(1), value(6))
    code.emit(Op.HYPOT, temporary(4), temporary(2), temporary(3))
    code.emit(Op.LT, temporary(5), literal(70), temporary(4))
    code.emit(Op.END)
    main = code.behaviour(0)

    def within(distance: Register) -> Register:
        code.emit(Op.WITHIN, temporary(6), 0, distance)
        return temporary(6)

    code.attempt(
        main,
        lambda block: code.follow(block, literal(ego_path), value(3)),
        (lambda: within(value(1)), lambda block: code.take(block, Command.BRAKE, value(0))),
        (lambda: within(value(2)), lambda _: code.emit(Op.TERMINATE, 0, terminate)),
    )
    code.emit(Op.HALT)
    other = code.behaviour(1)
    code.follow(other, literal(other_path), value(4), progress=1)
    code.emit(Op.HALT)
    return code.program(hand.road(), extra_values=7)


@pytest.fixture
def crossing_scenes(hand: Hand):
    """A function of (n, seed) to n scenes for `crossing`."""

    def draw(n: int, seed: int = 0, ego: int | None = None, other: int | None = None) -> Scenes:
        rng = np.random.default_rng(seed)
        ego = hand.route("south", ManeuverType.STRAIGHT) if ego is None else ego
        other = hand.route("east", ManeuverType.STRAIGHT) if other is None else other
        blocks, extras = [], []
        for _ in range(n):
            v0, v1 = rng.uniform(5 / 3.6, 80 / 3.6, 2)
            first = hand.on_route(ego, rng.uniform(3, 42), v0)
            blocks.append([first, hand.on_route(other, rng.uniform(3, 42), v1)])
            extras.append([rng.uniform(), rng.uniform(0, 20), rng.uniform(0, 5), v0, v1, first[0], first[1]])
        scenes = scenes_of(*blocks)
        return replace(scenes, values=np.column_stack([scenes.values, np.array(extras)]))

    return draw


@pytest.fixture(scope="session")
def turning(hand: Hand) -> Program:
    """As `crossing`, with an oncoming car that turns left across the ego's path."""
    return crossing_program(
        hand, hand.route("south", ManeuverType.STRAIGHT), hand.route("north", ManeuverType.LEFT_TURN)
    )
