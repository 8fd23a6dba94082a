"""A left turn across the path of the ego, made by hand: what every view is tried on."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cortex_dsl.report.findings.search_report import SearchReport
from engine.assessment import take
from engine.config import SearchConfig
from engine.maps import RoadSpec
from engine.outcomes import MEASURED, Assessment, Outcomes, blank_outcomes
from engine.program import ChoiceLabel, ParamSpace, Program, Requirement, Rule, Settings, VariantLabel
from engine.scenes import Scenes, Trajectory
from engine.search.campaign import Campaign
from engine.search.evaluations import Evaluations, distinct_collisions, figures, generation_figures, judge
from engine.search.insight.gene_effects import Probes, gene_effects
from engine.search.insight.kinds import blamed
from engine.search.protocol import Box
from engine.search.ranking import worst_cases
from engine.tables import CodeTables, Floats, RoadTables
from engine.vocabulary import Distribution, EndReason, GeneKind, State, Verdict

TIME_STEP = 0.05
SAMPLES = 90
TURN_SAMPLE = 30


def _none(table: type) -> dict[str, np.ndarray]:
    return dict.fromkeys(table._fields, np.zeros(0))


@pytest.fixture
def program() -> Program:
    """Two actors, three genes (one of them a choice), two requirements of the file and the built-in ones."""
    space = ParamSpace(
        names=("EGO_SPEED", "EGO_BRAKE", "WEATHER"),
        units=("km/h", "", ""),
        kinds=np.array([GeneKind.CONTINUOUS, GeneKind.CONTINUOUS, GeneKind.INDEX], dtype=np.int32),
        low=np.array([5.0, 0.0, 0.0]),
        high=np.array([80.0, 1.0, 2.0]),
        distribution=np.full(3, Distribution.UNIFORM, dtype=np.int32),
        shape=np.zeros((3, 2)),
        scale=np.array([1 / 3.6, 1.0, 1.0]),
        options=((), (), ("dry", "wet", "icy")),
        weights=((), (), ()),
    )
    choice = ChoiceLabel("egoInitLane", "north.in.1", "network.lanes[3]", 0, 4)
    return Program(
        name="left_turn",
        description="A: the ego crosses; an oncoming car turns left across its path.",
        digest="0123456789abcdef0123456789abcdef",
        source_text="",
        space=space,
        actors=("ego", "adversary"),
        requirements=(
            Requirement("ego starts where it should", 41),
            Requirement("adversary starts where it should", 42),
            Requirement("outlines inside the road", 0),
            Requirement("no overlap at the start", 0),
        ),
        rules=(Rule("(distance from ego to egoSpawnPt) > TERM_DIST", 43),),
        variants=(VariantLabel(1.0, (choice,), ()),),
        settings=Settings(),
        code=CodeTables(**_none(CodeTables)),
        road=RoadTables(**_none(RoadTables)),
        road_spec=RoadSpec(),
        step_lines=np.zeros(0, dtype=np.int32),
        routes=np.full((1, 2), -1, dtype=np.int32),
    )


@pytest.fixture
def trajectory() -> Trajectory:
    """The ego goes north and brakes; the adversary comes south and turns left, to the east."""
    states = np.zeros((SAMPLES, 2, len(State)))
    time = np.arange(SAMPLES, dtype=np.float64) * TIME_STEP
    states[:, :, State.PRESENT] = 1.0
    speed = np.maximum(0.0, 12.0 - 6.0 * np.maximum(0.0, time - 1.5))
    states[:, 0, State.X] = 1.75
    states[:, 0, State.Y] = -30.0 + np.cumsum(speed) * TIME_STEP
    states[:, 0, State.HEADING] = np.pi / 2
    states[:, 0, State.SPEED] = speed
    states[:, 0, State.BRAKE] = np.where(time > 1.5, 0.7, 0.0)
    straight = np.minimum(time, TURN_SAMPLE * TIME_STEP)
    angle = np.clip((time - TURN_SAMPLE * TIME_STEP), 0.0, np.pi / 2)
    states[:, 1, State.X] = -1.75 + 8.0 * (1 - np.cos(angle)) + 8.0 * np.maximum(0, time - 1.5 - np.pi / 2)
    states[:, 1, State.Y] = 20.0 - 8.0 * straight - 8.0 * np.sin(angle)
    states[:, 1, State.HEADING] = -np.pi / 2 + angle
    states[:, 1, State.SPEED] = 8.0
    return Trajectory(time, states, np.array([[4.5, 1.6], [4.3, 1.7]]), contact_sample=-1)


@pytest.fixture
def outcomes() -> Outcomes:
    """One run without contact that a rule ended."""

    def pair(value: float) -> Floats:
        return np.full((1, 1), value)

    return blank_outcomes(
        1,
        2,
        verdict=np.zeros(1, dtype=np.int32),
        collided=np.array([False]),
        end_reason=np.array([EndReason.RULE], dtype=np.int32),
        end_rule=np.zeros(1, dtype=np.int32),
        end_time=np.array([4.45]),
        steps=np.array([89], dtype=np.int32),
        min_distance=pair(2.31),
        min_distance_time=pair(3.1),
        max_closing_speed=pair(19.84),
        max_closing_time=pair(0.4),
        distance_at_ms=pair(38.2),
        ttc_at_ms=pair(1.925),
        ego_speed=pair(9.5),
        other_speed=pair(11.0),
        approach_angle=pair(1.5),
        closing_speed=pair(4.0),
        side=np.ones((1, 1), dtype=np.int32),
        left_road_time=np.array([[np.nan, 4.2]]),
        contact_actors=np.full((1, 2), -1, dtype=np.int32),
    )


@pytest.fixture
def collision(outcomes: Outcomes) -> Outcomes:
    """The same, but they touch."""
    return replace(
        outcomes,
        collided=np.array([True]),
        end_reason=np.array([EndReason.COLLISION], dtype=np.int32),
        end_rule=np.array([-1], dtype=np.int32),
        min_distance=np.zeros((1, 1)),
        contact_actors=np.array([[0, 1]], dtype=np.int32),
    )


@pytest.fixture
def scenes() -> Scenes:
    """One valid scene after three attempts."""
    return Scenes(
        genomes=np.array([[43.17, 0.7, 1.0]]),
        keys=np.zeros((1, 6), dtype=np.int64),
        verdict=np.zeros(1, dtype=np.int32),
        variant=np.zeros(1, dtype=np.int32),
        values=np.zeros((1, 30)),
        draws=np.zeros((1, 2)),
        attempts=np.array([3], dtype=np.int64),
        tested=np.array([[3, 2, 1, 1]], dtype=np.int64),
        failed=np.array([[1, 1, 0, 0]], dtype=np.int64),
    )


@pytest.fixture
def risk() -> SimpleNamespace:
    """What `engine.risk.assess` gives, for the run of `outcomes`."""
    return SimpleNamespace(
        score=np.array([11]),
        continuous=np.array([10.4]),
        parts=np.array([[0.0, 4.0, 3.0, 4.0]]),
        pair=np.array([0]),
    )


GENERATIONS, POPULATION = 8, 50


def _places(count: int) -> np.ndarray:
    return np.array([(i // POPULATION, i % POPULATION) for i in range(count)], dtype=np.int32)


def _assessment(genomes: np.ndarray, valid: np.ndarray) -> Assessment:
    """A brake below 0.3 collides, and decides nearly all of the risk."""
    count, shape = len(genomes), (len(genomes), 1)
    collided = (valid & (genomes[:, 1] < 0.3)).reshape(shape)
    parts = np.stack([np.where(collided, 10, 0), *np.full((3, *shape), 2)], axis=-1)
    continuous = np.where(valid, 10.0 * collided[:, 0] + 4.0 * (1 - genomes[:, 1]), np.nan).reshape(shape)

    def numbers(value: float) -> np.ndarray:
        return np.where(valid, value, np.nan).reshape(shape)

    blank = {row.name: np.full(shape, row.fill, row.dtype) for row in MEASURED}
    known = {
        "verdict": np.where(valid, int(Verdict.VALID), int(Verdict.EXHAUSTED)).reshape(shape),
        "variant": np.zeros(shape, dtype=np.int32),
        "attempts": np.ones(shape, dtype=np.int64),
        "tested": np.ones((count, 1, 4), dtype=np.int64),
        "failed": np.zeros((count, 1, 4), dtype=np.int64),
        "score": np.where(valid[:, None], parts.sum(axis=-1), -1),
        "continuous": continuous,
        "parts": np.where(valid[:, None, None], parts, -1),
        "pair": np.zeros(shape, dtype=np.int32),
        "collided": collided,
        "end_reason": np.where(collided, int(EndReason.COLLISION), int(EndReason.RULE)),
        "end_rule": np.where(collided, -1, 0),
        "end_time": numbers(4.0),
        "min_distance": np.where(collided, 0.0, numbers(2.0)),
        "min_distance_time": numbers(3.0),
        "max_closing_speed": numbers(12.0),
        "max_closing_time": numbers(1.0),
        "distance_at_ms": numbers(30.0),
        "ttc_at_ms": numbers(2.5),
        "ego_speed": numbers(8.0),
        "other_speed": numbers(12.0),
        "approach_angle": numbers(1.5),
        "closing_speed": numbers(9.0),
        "side": np.where(valid, 0, -1).reshape(shape),
        "left_road_time": numbers(np.nan),
    }
    made = blank | known
    made["sought"] = made["broken"] = np.zeros((*np.shape(made["collided"]), 0))
    return Assessment(**{"found": made["collided"], **made})


def _campaign(valid_share: float, space: ParamSpace) -> Campaign:
    rng, count = np.random.default_rng(7), GENERATIONS * POPULATION
    drawn = [rng.uniform(5, 80, count), rng.uniform(0, 1, count), rng.integers(0, 3, count)]
    genomes = np.column_stack(drawn).astype(np.float64)
    rollouts = _assessment(genomes, rng.uniform(size=count) < valid_share)
    verdict, fitness = judge(rollouts, "mean")
    evaluations = Evaluations(
        genomes=genomes,
        places=_places(count),
        births=_places(count),
        operator=np.zeros(count, dtype=np.int32),
        parents=np.full((count, 2, 2), -1, dtype=np.int32),
        reused=np.arange(count) % POPULATION == POPULATION - 1,
        verdict=verdict,
        fitness=fitness,
        keys=np.zeros((count, 1, 6), dtype=np.int64),
        rollouts=rollouts,
    )
    probes = Probes(np.array([0.4, 5.5, 0.0]), np.array([31, 30, 32]), np.array([3, 30, 0]), 32)
    return Campaign(
        method="ga",
        preset="cortex",
        space=space,
        config=SearchConfig(generations=GENERATIONS, population=POPULATION),
        evaluations=evaluations,
        generations=tuple(
            generation_figures(take(evaluations, evaluations.places[:, 0] == generation), generation)
            for generation in range(GENERATIONS)
        ),
        by_individual=figures(evaluations, np.ones(count, dtype=bool)),
        by_simulation=figures(evaluations, evaluations.simulated),
        distinct_collisions=distinct_collisions(evaluations),
        worst=worst_cases(evaluations),
        genes=gene_effects(Box.of(space), evaluations, probes),
        elapsed=1.4,
        status="finished",
        blame=blamed(evaluations, None),
    )


@pytest.fixture
def report(program: Program) -> SearchReport:
    """A search over the genes of `program` in which the weather does nothing."""
    folder = Path("runs/left_turn-0")
    files = tuple(folder / "worst" / f"{i:02d}.scn" for i in range(1, 11))
    return SearchReport(_campaign(0.75, program.space), folder, files)


@pytest.fixture
def nothing_valid(program: Program) -> SearchReport:
    """The same search where no scene was ever valid."""
    return SearchReport(_campaign(0.0, program.space), None)
