"""Programs made by hand: what lowering would write, with named registers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest

from engine.maps import RoadSpec
from engine.opcodes import Op
from engine.program import ParamSpace, Program, Requirement, Settings
from engine.road import Network, build_network, road_tables
from engine.tables import CodeTables
from engine.vocabulary import Column, Distribution, GeneKind

Row = tuple[Op, str, *tuple[str | int, ...]]
CAR = {Column.LENGTH: 4.5, Column.WIDTH: 1.8}


@dataclass(frozen=True)
class Gene:
    low: float
    high: float
    scale: float = 1.0
    kind: GeneKind = GeneKind.CONTINUOUS


@dataclass(frozen=True)
class Check:
    """A requirement: rows of code and the register of its result. Registers: `L0 V0 G0 D0 T0` by kind and number."""

    rows: Sequence[Row]
    result: str
    probability: float = 1.0


@dataclass(frozen=True)
class Sketch:
    """A program in short. Poses are the registers of x, y, heading of each actor."""

    poses: Sequence[tuple[str, str, str]]
    literals: Sequence[float] = (0.0, 1.0)
    variants: Sequence[Sequence[float]] = ((),)
    weights: Sequence[float] = (1.0,)
    impossible: Mapping[int, int] = field(default_factory=dict)
    """Variant -> number of its rejection reason."""
    genes: Sequence[Gene] = ()
    group_genes: Sequence[int] = ()
    group_start: Sequence[int] = ()
    draws: int = 0
    checks: Sequence[Check] = ()
    output: Sequence[Row] = ()
    pool: Sequence[float] = ()
    road_check: bool = True
    overlap_check: bool = True


def ints(values: object) -> np.ndarray:
    return np.asarray(values, dtype=np.int32)


def floats(values: object) -> np.ndarray:
    return np.asarray(values, dtype=np.float64)


class Assembler:
    """Turns a sketch into tables; the sizes of a car are two more literals."""

    def __init__(self, sketch: Sketch) -> None:
        self.sketch = sketch
        self.literals = (*sketch.literals, *CAR.values())
        counts = (len(self.literals), len(sketch.variants[0]), len(sketch.genes), sketch.draws)
        self.start = dict(zip("LVGDT", np.cumsum((0, *counts)).tolist(), strict=True))
        self.rows: list[list[int]] = []
        self.temporaries = 1

    def register(self, name: str | int) -> int:
        if isinstance(name, int):
            return name
        number = int(name[1:])
        if name[0] == "T":
            self.temporaries = max(self.temporaries, number + 5)
        return self.start[name[0]] + number

    def segment(self, rows: Sequence[Row]) -> tuple[int, int]:
        start = len(self.rows)
        for op, *operands in rows:
            numbers = [self.register(operand) for operand in operands]
            self.rows.append([int(op), *numbers, *[0] * (5 - len(numbers))])
        self.rows.append([int(Op.END), 0, 0, 0, 0, 0])
        return start, len(self.rows)

    def actor(self, pose: tuple[str, str, str]) -> list[int]:
        sizes = {column: self.register(f"L{len(self.sketch.literals) + i}") for i, column in enumerate(CAR)}
        columns = {**dict(zip((Column.X, Column.Y, Column.HEADING), pose, strict=True)), **sizes}
        return [self.register(columns.get(column, "L0")) for column in Column]

    def tables(self) -> CodeTables:
        sketch = self.sketch
        variants = len(sketch.variants)
        checks = [(*self.segment(check.rows), self.register(check.result)) for check in sketch.checks]
        output = self.segment(sketch.output)
        registers = [register for pose in sketch.poses for register in self.actor(pose)]
        group_start = sketch.group_start or (0, variants)
        weights = np.split(floats(sketch.weights), group_start[1:-1])
        none = np.zeros((1, len(sketch.poses)), dtype=np.int32)
        return CodeTables(
            scene_code=ints(self.rows),
            step_code=np.zeros((0, 6), dtype=np.int32),
            literals=floats(self.literals),
            pool=floats(sketch.pool),
            variant_values=floats(sketch.variants).reshape(variants, -1),
            variant_template=ints([-1 if v in sketch.impossible else 0 for v in range(variants)]),
            variant_rejection=ints([len(checks) + sketch.impossible.get(v, -1 - len(checks)) for v in range(variants)]),
            variant_cumulative=np.concatenate([np.cumsum(group) / group.sum() for group in weights]),
            group_start=ints(group_start),
            group_gene=ints(sketch.group_genes),
            group_size=ints([sketch.genes[g].high - sketch.genes[g].low + 1 for g in sketch.group_genes]),
            gene_scale=floats([gene.scale for gene in sketch.genes]),
            requirement_segment=ints(checks).reshape(1, -1, 3),
            requirement_probability=floats([check.probability for check in sketch.checks]),
            output_segment=ints([output]),
            output_register=ints([registers]),
            road_check=ints([sketch.road_check] * len(sketch.poses)),
            overlap_check=ints([sketch.overlap_check] * len(sketch.poses)),
            actor_kind=none[0],
            behaviour_entry=none - 1,
            main_block=none,
            rule_segment=np.zeros((1, 0, 3), dtype=np.int32),
            rule_kind=ints([]),
            formula=ints([]).reshape(-1, 3),
            temporal_root=ints([]),
            temporal_rule=ints([]),
            monitor_entry=none[:, :0],
            monitor_block=none[:, :0],
            monitor_started=ints([]),
            actor_present=none[0] + 1,
            margin_segment=np.full((1, len(checks), 3), -1, dtype=np.int32),
            sizes=ints([self.start["T"] + self.temporaries, sketch.draws, len(registers), 0, 0, 0]),
        )


@pytest.fixture(scope="session")
def network() -> Network:
    """The four-way intersection of the worked example."""
    return build_network(RoadSpec())


@pytest.fixture(scope="session")
def assemble(network: Network) -> Callable[..., Program]:
    """A function from the fields of a `Sketch` to a program; genes and checks may be plain tuples."""
    road = road_tables(network)

    def build(genes: Sequence[tuple] = (), checks: Sequence[tuple] = (), **fields: Any) -> Program:
        sketch = Sketch(genes=[Gene(*gene) for gene in genes], checks=[Check(*check) for check in checks], **fields)
        own, reasons = sketch.genes, sorted(set(sketch.impossible.values()))
        names = [*(f"check {i}" for i in range(len(sketch.checks))), *(f"reason {i}" for i in reasons)]
        space = ParamSpace(
            names=tuple(f"GENE_{i}" for i in range(len(own))),
            units=("",) * len(own),
            kinds=ints([gene.kind for gene in own]),
            low=floats([gene.low for gene in own]),
            high=floats([gene.high for gene in own]),
            distribution=np.full(len(own), Distribution.UNIFORM, dtype=np.int32),
            shape=np.zeros((len(own), 2)),
            scale=floats([gene.scale for gene in own]),
            options=((),) * len(own),
            weights=((),) * len(own),
        )
        return Program(
            name="test",
            description="",
            digest="",
            source_text="",
            space=space,
            actors=tuple(f"actor_{i}" for i in range(len(sketch.poses))),
            requirements=tuple(Requirement(name, 1) for name in (*names, "inside the road", "no overlap")),
            rules=(),
            variants=(),
            settings=Settings(),
            code=Assembler(sketch).tables(),
            road=road,
            road_spec=RoadSpec(),
            step_lines=ints([]),
            routes=ints([]),
        )

    return build
