"""Every setting of the engine, as frozen dataclasses. No setting lives anywhere else."""

from dataclasses import field
from typing import Any, Protocol

from engine.frozen import frozen


@frozen
class SimulationConfig:
    """How scenes are drawn and run."""

    time_step: float = 0.05
    """Step of the simulation [s]."""
    max_time: float = 30.0
    """End of a run that nothing else ended [s]."""
    max_attempts: int = 2000
    """Rejection-sampling attempts per scene; Scenic's default."""
    prune: bool = False
    """Jump over attempts that surely fail (`engine.feasibility.pruning`); a genome that allows no scene is infeasible.
    The law of scenes stays the same, but a seed gives other ones."""
    instruction_budget: int = 100_000
    """Instructions one behaviour may run in one step before it is called stuck."""


@frozen
class ContactConfig:
    """Contact physics; the values and their reasons are in the physics reference.

    Restitution, friction, rolling resistance and whether drivers go on hold in both hosts; the rest is for pymunk.
    """

    restitution: float = 0.15
    """Speed of parting over closing speed, on the normal."""
    friction: float = 0.5
    """Of outlines on one another."""
    substep: float = 0.0025
    """Step of pymunk from the first contact on [s]."""
    aftermath: float = 4.0
    """How long the world goes on after first contact, or until everything rests [s]."""
    collision_slop: float = 0.01
    collision_persistence: int = 1
    rolling_resistance: float = 0.015
    """Of wheels that nobody drives, as a share of the weight on them. Source: Gillespie 1992, "Fundamentals of Vehicle
    Dynamics", chapter 4, passenger cars on concrete."""
    drivers_go_on: bool = False
    """Whether the driver of a body struck by others than the ego drives on once its wheels grip; else it rolls out."""


@frozen
class SearchConfig:
    """A search campaign. Budget = generations x population individuals."""

    generations: int = 30
    population: int = 100
    seed: int = 0
    rollouts: int = 1
    aggregate: str = "mean"
    """How k rollouts of one genome become one fitness: mean | max | q90 (any quantile qNN)."""
    jobs: int = 1
    engine: str = "batch"
    run: int = 0
    """Number of this run in a study; part of the stream key."""
    probes: int = 32
    """Cases in which each gene is moved alone at the end of a campaign, beside the budget (search.genes); 0 = none."""


@frozen
class GAConfig:
    """The genetic algorithm of the paper, every gap decided (see search.methods.ga)."""

    preset: str = "cortex"
    selection_rate: float = 0.1
    crossover_rate: float = 0.8
    mutation_rate: float = 0.1
    tournament: int = 2
    """Size of the parents' tournament; 1 = uniform over the valid (preset `cortex-literal`)."""
    per_individual: bool = False
    """Read the three rates as shares of individuals instead of shares of draws."""
    max_redraws: int = 10
    """How often a child equal to a known genome is redrawn before one gene is mutated."""


class ActorDriver(Protocol):
    """Who drives the actors that a program leaves to controllers, as `engine.driving.blocks.Driver` does."""

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
        """Whether scenes can be driven that have not been driven before."""
        ...

    def without_history(self) -> "ActorDriver":
        """The same, of whom nothing is known yet."""
        ...

    def has(self, key: Any, genome: Any) -> bool:
        """Whether the scene of a stream key and a genome can be driven."""
        ...

    def drive(self, program: Any, scenes: Any, config: SimulationConfig, contact: ContactConfig, jobs: int = 1) -> Any:
        """A `driving.Driven`."""
        ...


@frozen
class Config:
    simulation: SimulationConfig = field(default_factory=SimulationConfig)
    contact: ContactConfig = field(default_factory=ContactConfig)
    search: SearchConfig = field(default_factory=SearchConfig)
    ga: GAConfig = field(default_factory=GAConfig)
    driver: ActorDriver | None = None
    """Who drives whom the file leaves to a controller."""
