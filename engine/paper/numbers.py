"""What the paper prints, in the order of its scenarios A to F.

Source: "CORTEX-AVD: A Framework for CORner Case Testing and EXploration in Autonomous Vehicle Development", sections
"Results" and "Discussion". One run of each method in each scenario: 30 generations of 100.
"""

from dataclasses import dataclass

SCENARIOS = ("A", "B", "C", "D", "E", "F")
FILES = (
    "left_turn",
    "left_against_crossing",
    "crossing_left_turn",
    "right_and_oncoming_left",
    "right_into_crossing",
    "three_way_left",
)
"""The same scenarios among our examples."""
GENERATIONS, POPULATION = 30, 100
RUNS = GENERATIONS * POPULATION
"""Individuals of one method in one scenario."""
SECONDS_PER_SIMULATION = 13.5
HOURS = 135.0


@dataclass(frozen=True)
class Printed:
    """The figures of one method; each tuple holds one number for each scenario."""

    rl: tuple[float, ...]
    """Mean risk."""
    nc: tuple[int, ...]
    """Collisions."""
    nc_last: tuple[int, ...]
    """Collisions in generations 21 to 30."""
    mdg_last: tuple[float, ...]
    """Mean minimum distance in generations 21 to 30 [cm] …"""
    mdec_last: tuple[float, ...]
    """… and without the collisions."""
    nis: tuple[int, ...]
    """Invalid individuals."""
    nis_last: tuple[int, ...]
    """Invalid individuals in generations 21 to 30."""
    mean_rl: float
    """As printed for all six."""
    mdg: float
    """As printed for all six [cm]."""
    mdec: float

    @property
    def valid(self) -> tuple[int, ...]:
        return tuple(RUNS - invalid for invalid in self.nis)


GA = Printed(
    rl=(13.3, 7.5, 8.8, 9.8, 7.7, 10.1),
    nc=(673, 577, 544, 386, 377, 692),
    nc_last=(220, 249, 273, 158, 195, 312),
    mdg_last=(69.4, 121.5, 101.4, 144.6, 143.9, 166.8),
    mdec_last=(77.9, 141.8, 122.6, 160.9, 154.7, 191.5),
    nis=(468, 665, 725, 604, 1047, 922),
    nis_last=(20, 50, 36, 77, 159, 187),
    mean_rl=9.54,
    mdg=133.2,
    mdec=149.6,
)
RANDOM = Printed(
    rl=(9.7, 6.1, 7.6, 7.5, 6.0, 9.7),
    nc=(651, 355, 327, 322, 284, 543),
    nc_last=(204, 133, 101, 109, 82, 174),
    mdg_last=(138.9, 187.5, 162.5, 180.8, 213.6, 200.7),
    mdec_last=(161.2, 217.6, 178.2, 195.7, 224.6, 236.1),
    nis=(771, 885, 778, 924, 798, 1059),
    nis_last=(267, 312, 249, 325, 286, 371),
    mean_rl=7.75,
    mdg=180.6,
    mdec=202.2,
)
METHODS = {"GA": GA, "random": RANDOM}


@dataclass(frozen=True)
class Study:
    """One row of the paper's comparison of studies, as printed."""

    name: str
    cases: str
    seconds: str
    """For each simulation."""
    collisions: str
    valid: str
    metrics: str


STUDIES = (
    Study("Klück et al. 2019 (performance)", "9,135", "not stated", "other meaning", "not collected", "TTC"),
    Study("Tian et al. 2022 (MOSAT)", "50,000 (estimated)", "24-55", "1.1-2.85 %", "other meaning", "METTC, DFP, ..."),
    Study("Gambi et al. 2019", "a budget of hours", "41.1-152.6", "not stated", "34-39 %", "distance"),
    Study("Langford et al. 2019", "4,989", "other meaning", "not stated", "not stated", "distance"),
    Study("Tang et al. 2021", "10,240", "60", "not stated", "other meaning", "distance"),
    Study("Ebadi et al. 2021", "200", "10 (a limit)", "GA 15 (7.5 %), random 8 (4 %)", "not collected", "distance"),
    Study("Klück et al. 2019 (genetic)", "2,342", "not stated", "72 (3.1 %)", "GA 878, random 468", "TTC"),
    Study("Kaufmann et al. 2021", "1,800", "10 (a limit)", "233 (12.9 %)", "other meaning", "distance"),
    Study("Zhou et al. 2023", "40,000", "56", "GA 2,666 (13.3 %), random 747 (3.7 %)", "not collected", "not stated"),
    Study("Klück et al. 2023", "83,726", "not stated", "GA 5,946 (30.7 %)", "not collected", "TTC"),
    Study(
        "CORTEX-AVD",
        "36,000",
        "13.5",
        "GA 3,249 (18.1 %), random 2,482 (13.8 %)",
        "GA 75.4 %, random 71 %",
        "RL, NC, MD",
    ),
)
