"""All settings of the engine, as frozen dataclasses."""

from dataclasses import field
from typing import Any, Protocol

from engine.frozen import frozen
from engine.vocabulary import STORED

DEFAULT_REFERENCES = ("careful", "reg157", "rss", "fsm", "cc")
"""Names of the reference drivers that judge a collision unless others are named (`engine.references`)."""


@frozen
class SimulationConfig:
    """Settings of sampling and simulation."""

    time_step: float = 0.05
    """Step of the simulation [s]."""
    max_time: float = 30.0
    """End of a run without an earlier end [s]."""
    max_attempts: int = 2000
    """Rejection-sampling attempts per scene; Scenic's default."""
    prune: bool = False
    """Skip attempts that surely fail (`engine.feasibility.pruning`); a genome that allows no scene is infeasible. The
    distribution of scenes is unchanged, but a seed gives different scenes.
    """
    instruction_budget: int = 100_000
    """Instructions that one behaviour may run in one step before it counts as stuck."""


@frozen
class ContactConfig:
    """Settings of contact physics; the physics reference has the values and their reasons.

    Restitution, friction, rolling resistance and `drivers_go_on` apply to both hosts; the rest to pymunk.
    """

    restitution: float = 0.15
    """Coefficient of restitution: separation speed over closing speed, along the normal."""
    friction: float = 0.5
    """Friction coefficient between outlines."""
    substep: float = 0.0025
    """Step of pymunk from the first contact on [s]."""
    aftermath: float = 4.0
    """Duration of the world host's run after first contact, unless all bodies rest earlier [s]."""
    collision_slop: float = 0.01
    collision_persistence: int = 1
    rolling_resistance: float = 0.015
    """Rolling resistance of wheels without a driver, as a share of their load. Source: Gillespie 1992, "Fundamentals of
    Vehicle Dynamics", chapter 4, passenger cars on concrete.
    """
    drivers_go_on: bool = False
    """True if a driver struck by an actor other than the ego drives on once its wheels grip; else its vehicle rolls
    out.
    """


@frozen
class SearchConfig:
    """A search campaign. Budget = generations x population individuals."""

    generations: int = 30
    population: int = 100
    seed: int = 0
    rollouts: int = 1
    aggregate: str = "mean"
    """Aggregate of k rollouts of one genome: mean | max | q90 (any quantile qNN)."""
    jobs: int = 1
    engine: str = "batch"
    run: int = 0
    """Number of this run in a study; part of the stream key."""
    probes: int = 32
    """Number of cases in which each gene is moved alone at the end of a campaign, outside the budget; 0 = none."""
    references: tuple[str, ...] = DEFAULT_REFERENCES
    """Names of the reference drivers that judge each collision."""

    @property
    def simulations(self) -> int:
        """Return the planned number of simulations; a repeated elite counts again."""
        return self.generations * self.population * self.rollouts


@frozen
class GAConfig:
    """The genetic algorithm of the paper, with a decision for every gap (see search.methods.ga)."""

    preset: str = "cortex"
    selection_rate: float = 0.1
    crossover_rate: float = 0.8
    mutation_rate: float = 0.1
    tournament: int = 2
    """Size of the parents' tournament; 1 = uniform over the valid (preset `cortex-literal`)."""
    per_individual: bool = False
    """Read the three rates as shares of individuals instead of shares of draws."""
    max_redraws: int = 10
    """Maximum number of times that a child equal to a known genome is redrawn before one gene is mutated."""


class ActorDriver(Protocol):
    """Driver of the actors that a program leaves to controllers, such as `engine.driving.blocks.Driver`."""

    @property
    def name(self) -> str: ...
    @property
    def digest(self) -> str: ...
    @property
    def block(self) -> int: ...
    @property
    def observe(self) -> str: ...
    @property
    def can_drive_new_scenes(self) -> bool:
        """Return True if it can drive scenes that were not driven before."""
        ...

    def without_history(self) -> "ActorDriver":
        """Return a copy without history."""
        ...

    def has(self, key: Any, genome: Any) -> bool:
        """Return True if the scene of a stream key and a genome can be driven."""
        ...

    def drive(
        self,
        program: Any,
        scenes: Any,
        config: SimulationConfig,
        contact: ContactConfig,
        jobs: int = 1,
        measures: int = STORED,
    ) -> Any:
        """Drive scenes and return a `driving.Driven`, whose outcomes contain `measures`."""
        ...


@frozen
class Config:
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    contact: ContactConfig = field(default_factory=ContactConfig)
    search: SearchConfig = field(default_factory=SearchConfig)
    ga: GAConfig = field(default_factory=GAConfig)
    driver: ActorDriver | None = None
    """Driver of the actors that the file leaves to a controller."""
