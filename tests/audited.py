"""Results of each kind that an auditor's sheet can be made of: made once a session; whoever writes takes a copy."""

from collections.abc import Callable
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from tests.runs import LEFT_TURN, shared

FOLLOWING = '''"""A faster car comes up behind a slower one."""

map intersection(approach=500 m)
param SPEED = Range(20, 60) km/h
param GAP = Range(10, 40) m
ego = new Car at (1.75, -490), facing 90 deg, with speed SPEED, with behavior FollowLaneBehavior({speed})
lead = new Car ahead of ego by GAP, with speed 20 km/h, with behavior FollowLaneBehavior(20 km/h)
expect always ego.speed < 58 km/h as "slow"
expect eventually ego.x != lead.x as "moved"
domain "speed" ego.speed at start in 10 km/h steps from 20 km/h to 60 km/h
domain "gap" GAP in 10 m steps from 10 m to 50 m
domain "end" ego.speed at end in 20 km/h steps from 0 km/h to 60 km/h
terminate after 4 s
'''
"""A file with domains; the third speed cell and the last gap are rare or empty."""
SLOW = "EmergencyBrakeBehavior(FollowLaneBehavior(EGO_SPEED), threshold=0.8 s)"
"""A driver that fails in some cells, and in others within their tolerances only."""


def written(factory: pytest.TempPathFactory, name: str, speed: str = "SPEED") -> Path:
    path = factory.getbasetemp() / f"{name}.scn"
    path.write_text(FOLLOWING.format(speed=speed), encoding="utf-8")
    return path


def search(factory: pytest.TempPathFactory) -> Path:
    return shared(factory, "audited-search", LEFT_TURN, "--random", "--generations", 4, "--population", 60, "--seed", 3)


def domains(factory: pytest.TempPathFactory) -> Path:
    words = ("--random", "--generations", 4, "--population", 50, "--seed", 5)
    return shared(factory, "audited-domains", written(factory, "following"), *words)


def genetic(factory: pytest.TempPathFactory) -> Path:
    return shared(factory, "audited-ga", LEFT_TURN, "--ga", "--generations", 3, "--population", 40, "--seed", 1)


def sequence(factory: pytest.TempPathFactory) -> Path:
    """A method without independent draws."""
    words = ("--method", "sobol", "--generations", 3, "--population", 30, "--seed", 1)
    return shared(factory, "audited-sequence", LEFT_TURN, *words)


def suite(factory: pytest.TempPathFactory) -> Path:
    words = ("--only", "CCRs/*/[15]*", "--only", "CPNA day/[145]*", "--budget", 30)
    return shared(factory, "audited-suite", "suite", "euroncap-2026", "--ego", SLOW, *words, code=4)


def comparison(factory: pytest.TempPathFactory) -> Path:
    a, b = written(factory, "first"), written(factory, "second", "0.9 * SPEED")
    return shared(factory, "audited-comparison", "compare", a, b, "--budget", 120, code=4)


def coverage(factory: pytest.TempPathFactory) -> Path:
    words = ("--budget", 150, "--ways", 2)
    return shared(factory, "audited-coverage", "coverage", written(factory, "following"), *words)


KINDS: dict[str, Callable[[pytest.TempPathFactory], Path]] = {
    made.__name__: made for made in (search, domains, genetic, sequence, suite, comparison, coverage)
}


def audit(folder: Path, *words: object) -> int:
    """Write the sheet of a folder."""
    return main(["report", str(folder), "--audit", *map(str, words)])
