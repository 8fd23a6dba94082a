"""Data of a run: sampled `Scenes`, the states over time (`Trajectory`), and each `Impact`.

Arrays are row-aligned: row i of every array belongs to scene i.
"""

from dataclasses import field

import numpy as np

from engine.display import counted, facts_table
from engine.frozen import frozen
from engine.program import Program
from engine.tables import Bools, Floats, Ints
from engine.vocabulary import Column, Verdict


@frozen
class Scenes:
    """Concrete scenes drawn for genomes: `engine.sampling.sample(program, genomes, keys, config)`."""

    genomes: Floats
    """(n, d) in the file's own units."""
    keys: Ints
    """(n, 6) `StreamKey` rows, int64."""
    verdict: Ints
    """(n,) `Verdict`"""
    variant: Ints
    """(n,) Variant of the accepted attempt, -1 if there is none."""
    values: Floats
    """(n, n_values) Scene values: `len(Column)` per actor, then values that behaviours use. NaN if invalid."""
    draws: Floats
    """(n, n_draws) the uniform numbers of the accepted attempt (nuisance draws)."""
    attempts: Ints
    """(n,) int64"""
    tested: Ints
    """(n, requirements) int64 Number of tests of each requirement."""
    failed: Ints
    """(n, requirements) int64 Number of failures of each requirement, conditional on the earlier requirements."""
    actions: Floats = field(default_factory=lambda: np.zeros((0, 0, 0)))
    """(n, turns, numbers) Decisions of controllers at each turn (`engine.control`), the last of which stays in effect;
    empty before they have driven, and for programs without controllers.
    """

    def __len__(self) -> int:
        return len(self.verdict)

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        return f"Scenes({len(self)}: {int(self.valid.sum())} valid)"

    def _repr_html_(self) -> str:
        counts = ((verdict.name.lower(), int((self.verdict == verdict).sum())) for verdict in Verdict)
        rows = [("scenes", f"{len(self):,}"), *((name, f"{count:,}") for name, count in counts if count)]
        return facts_table([*rows, ("attempts", f"{int(self.attempts.sum()):,}")])

    @property
    def valid(self) -> Bools:
        return self.verdict == 0


@frozen
class Trajectory:
    """One run over time, sampled at every step; samples after first contact carry free bodies."""

    time: Floats
    """(samples,) [s]"""
    states: Floats
    """(samples, actors, len(State))"""
    outlines: Floats
    """(actors, 2) length, width [m]"""
    contact_sample: int
    """Index of the last sample before first contact; -1 without contact."""
    watched: Floats = field(default_factory=lambda: np.zeros((0, 0)))
    """(scored samples, rules) Values of the rules of kind WATCH at each sample (`engine.metrics` names them); other
    columns are undefined. Empty if a program watches nothing.
    """
    heights: Floats | None = None
    """(samples, actors) Heights of the road at the actors [m]; None on a road without bridges."""

    def __repr__(self) -> str:
        """Return one line, for notebooks."""
        sizes = f"{counted(len(self.time), 'sample')} of {counted(self.states.shape[1], 'actor')}"
        contact = f", contact after sample {self.contact_sample}" if self.contact_sample >= 0 else ""
        return f"Trajectory({sizes}, {self.time[-1]:.2f} s{contact})"


def actor_columns(program: Program, values: Floats) -> Floats:
    """Return (actors, len(Column)) the properties of the actors of one scene; `values` is its row of scene values."""
    return values[: len(program.actors) * len(Column)].reshape(len(program.actors), len(Column))


def weather_sight(program: Program, variant: Ints, values: Floats) -> Floats:
    """Return (n,) the weather's range of sight [m] in scenes of variants (n,) with values (n, n_values)."""
    sight = np.array([each.sight for each in program.variants], dtype=np.int64)[np.maximum(variant, 0)]
    return np.where(sight >= 0, values[np.arange(len(values)), sight], np.inf)


def groups_of(program: Program, genomes: Floats) -> Ints:
    """Return (n,) the group of variants that each genome's discrete genes pick, most significant gene first."""
    group = np.zeros(len(genomes), dtype=np.int64)
    for gene, size in zip(program.code.group_gene, program.code.group_size, strict=True):
        group = group * size + (genomes[:, gene] - program.space.low[gene]).astype(np.int64)
    return group


@frozen
class Impact:
    """One impact between two actors. Pairs of values belong to the lower actor and to the higher actor."""

    time: float
    """Time at which the bodies met [s]."""
    actors: tuple[int, int]
    """Actors of the impact; the second may be `A_BUILDING`."""
    point: tuple[float, float]
    """Point of the impact, x, y [m]."""
    delta_v: tuple[float, float]
    """Change of each velocity, as a magnitude [m/s]; 0 for a fixed body. It includes all impulses on the body during
    its contact, from any body: for a body between two others, they largely cancel.
    """
    direction: tuple[float, float]
    """Direction of each change in the body's frame when they met [rad, anticlockwise from its heading]."""
    closing_speed: float
    """Magnitude of the difference between the centres' velocities when they met [m/s]."""
    impact_angle: float
    """Heading of the higher actor relative to the lower actor's, in [-pi, pi) [rad]; 0: the same way, pi: head on."""
    clock: tuple[int, int]
    """Place on each outline as a clock direction from its centre: 12 straight ahead, 3 to the right."""
