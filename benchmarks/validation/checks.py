"""The checks: who judges which files, asked how, and what they said."""

import json
import re
import subprocess
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from benchmarks.validation.environments import python_of
from benchmarks.validation.items import Item
from benchmarks.validation.round_trip import round_trip

CHECKERS = Path(__file__).parent / "checkers"
LONGEST = 3600.0
"""Of one checker on all its files [s]."""


@dataclass(frozen=True)
class Check:
    """A row of the result."""

    checker: str
    """Name of the environment and of the script; "" for our own reader."""
    title: str
    what: str
    """What is asked, in words."""
    kinds: tuple[str, ...]
    """Of the items that are held against it."""
    spoil: tuple[str, str]
    """A pattern, and what to put there: a file that is spoilt like this must not pass."""


NO_LINK = (r"<laneLink [^>]*>", "")
NO_WAY_OUT = (r"<successor elementType=\"road\"[^>]*>", "")
NO_OBSTACLE = (r"(?s)<dynamicObstacle .*</dynamicObstacle>", "")
CHECKS = (
    Check("opendrive", "ASAM's OpenDRIVE checker", "no issue of any level", ("road",), ('from="-?1"', 'from="7"')),
    Check(
        "openscenario",
        "ASAM's OpenSCENARIO XML checker",
        "no issue of any level",
        ("replay", "maneuver"),
        (r'rule="\w+"', 'rule="perhaps"'),
    ),
    Check("netconvert", "SUMO's netconvert", "no warning, a connection for each maneuver", ("road",), NO_WAY_OUT),
    Check("scenic", "Scenic's road parser", "every intersection, every maneuver", ("road",), NO_LINK),
    Check(
        "scenic",
        "Scenic's compiler",
        "everybody starts where ours do, to 1e-6",
        ("scenic",),
        (r"(ego = new \w+ at \(-?\d+)", r"\g<1>1"),
    ),
    Check(
        "scenic",
        "Scenic's `can see`",
        "equal verdicts, but where less than 1 degree is seen",
        ("looks",),
        ('"seen": true', '"seen": false'),
    ),
    Check(
        "scenic",
        "Scenic's sampler",
        "scenes of the same law: 400 each, all tests together at 0.01",
        ("samples",),
        (r"Range\((-?\d+), (\d+)\)", r"Range(\g<1>, 1\g<2>)"),
    ),
    Check("commonroad", "CommonRoad's reader", "no warning, everybody there", ("commonroad",), NO_OBSTACLE),
    Check(
        "commonroad_collisions",
        "CommonRoad's collision checker",
        "our contact, within one step",
        ("commonroad",),
        NO_OBSTACLE,
    ),
    Check(
        "crime",
        "CommonRoad-CriMe",
        "time gap, TTC, WTTC, TET, TIT, TTB, what braking and steering need, delta-V",
        ("encounter",),
        (r'"TTC": [\d.]+', '"TTC": 0.5'),
    ),
    Check(
        "scenario_runner",
        "CARLA's ScenarioRunner and map parser",
        "everybody where ours is at every tick, to 1e-5 m",
        ("carla",),
        (r'name="ahead" value="[^"]*"', 'name="ahead" value="0.5"'),
    ),
    Check("omega_prime", "omega-prime", "valid columns, everybody at every sample", ("csv", "parquet"), ("yaw", "yew")),
    Check(
        "",
        "our own reader",
        "metrics to 1e-6 and the risk as they were",
        ("replay", "csv", "parquet"),
        (r'x="[^"]*"', 'x="500"'),
    ),
)


@dataclass(frozen=True)
class Verdict:
    """What a check said of one kind of files."""

    check: Check
    kind: str
    versions: tuple[str, ...]
    """Of the format, where it has several."""
    files: int
    findings: dict[str, list[str]]
    """By file, only where there are any."""


def judged(check: Check, items: Sequence[Item]) -> list[Verdict]:
    """One verdict for each kind of item that the check is for."""
    return [_verdict(check, kind, _once([item for item in items if item.kind == kind])) for kind in check.kinds]


def _once(items: Sequence[Item]) -> list[Item]:
    """Without repetitions of a file: cases share their road."""
    return list({item.file: item for item in items}.values())


def _verdict(check: Check, kind: str, items: Sequence[Item]) -> Verdict:
    there = [item for item in items if not item.problem]
    said = [*zip(there, _ask(check, there), strict=True), *((item, [item.problem]) for item in items if item.problem)]
    findings = {str(item.file): found for item, found in said if found}
    spoilt = _spoilt(check, there)
    if spoilt is not None and not _ask(check, [spoilt])[0]:
        findings[str(spoilt.file)] = ["passes, and was spoilt on purpose"]
    return Verdict(check, kind, tuple(dict.fromkeys(item.version for item in items)), len(items), findings)


def _spoilt(check: Check, items: Sequence[Item]) -> Item | None:
    """A spoilt copy of an item that the pattern fits, one with contact if there is any; None where none is text."""
    for item in sorted(items, key=lambda item: not item.facts.get("contact")):
        content = item.file.read_bytes()
        with suppress(UnicodeDecodeError):
            text, times = re.subn(*check.spoil, content.decode(), count=1)
            if times:
                copy = item.file.with_name(f"spoilt-{item.file.name}")
                copy.write_text(text, encoding="utf-8")
                _copy_companion(item.file, copy)
                return replace(item, file=copy)
    return None


def _copy_companion(file: Path, copy: Path) -> None:
    """What a CommonRoad scenario is read with."""
    companion = file.name.replace(".cr.xml", ".solution.xml")
    if companion != file.name:
        solution = file.with_name(companion).read_bytes()
        copy.with_name(f"spoilt-{companion}").write_bytes(solution)


def _ask(check: Check, items: Sequence[Item]) -> list[list[str]]:
    return answers(check.checker, items) if check.checker else [round_trip(item) for item in items]


def answers(checker: str, items: Sequence[Item], python: str = "") -> list[list[str]]:
    """Findings of each file, from the checker's own interpreter, or another one that has it."""
    jobs = json.dumps([{"file": str(item.file), **item.facts} for item in items])
    command = [python or str(python_of(checker)), str(CHECKERS / f"ask_{checker}.py")]
    done = subprocess.run(command, input=jobs, capture_output=True, text=True, check=False, timeout=LONGEST)
    try:
        found = json.loads(done.stdout)
    except json.JSONDecodeError:
        last = "\n".join(done.stderr.strip().splitlines()[-5:])
        return [[f"{checker} broke down: {last}"] for _ in items]
    return found
