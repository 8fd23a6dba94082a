"""Cases of a search as scenarios of their own, in the run's folder: the worst, and those over which the driver failed.

| folder    | holds                                                                        |
|-----------|------------------------------------------------------------------------------|
| worst/    | the worst cases, which run to the same outcome                               |
| failures/ | the first scenes over which a controller failed, to be driven again by it    |
"""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from cortex_dsl.api.concrete import map_copies
from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign
from engine.search.ranking import Case, lost_cases

if TYPE_CHECKING:
    from engine.scenes import Scenes

WORST_FOLDER, FAILURE_FOLDER = "worst", "failures"


class Writable(Protocol):
    """Interface of a scenario that writing a case uses."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...
    def scene(self, case: Case) -> "Scenes": ...
    def driven_by(self, ego: object, /) -> "Writable": ...
    def concrete_files(self, scenes: "Scenes", row: int = 0, remark: str = "", name: str = "") -> dict[str, str]: ...


CASE = "[0-9][0-9].scn"


def worst_files(folder: Path) -> list[Path]:
    """Return the scenarios of the worst cases, in their order."""
    return sorted((folder / WORST_FOLDER).glob(CASE))


def stale_cases(folder: Path, files: Mapping[str, bytes]) -> list[Path]:
    """Return cases that are there from before the run went on, and are none of these files."""
    found = (path for name in (WORST_FOLDER, FAILURE_FOLDER) for path in (folder / name).glob(CASE))
    return [path for path in found if f"{path.parent.name}/{path.name}" not in files]


def case_files(scenario: Writable, campaign: Campaign, file: str, link: str) -> dict[str, bytes]:
    """Return the cases of a search in `file` as scenarios, by paths relative to the run's folder; `link` is the last of
    the journal's chain.
    """
    # a driver that drives again decides anew
    undriven = scenario if scenario.config.driver is None else scenario.driven_by(None)
    cases = ((FAILURE_FOLDER, lost_cases(campaign.evaluations)), (WORST_FOLDER, campaign.worst))
    copies = map_copies(scenario.program)
    files: dict[str, bytes] = {}
    for folder, chosen in cases:
        for case in chosen:
            files |= {f"{folder}/{name}": text for name, text in _case(undriven, case, file, link).items()}
        if chosen:
            files |= {f"{folder}/{name}": content for name, content in copies.items()}
    return files


def _case(scenario: Writable, case: Case, file: str, link: str) -> dict[str, bytes]:
    what = "the driver failed" if case.lost else f"risk {case.score}"
    remark = f"case {case.rank} of a search in {file}: {what}" + (f"\njournal {link}" if link else "")
    files = scenario.concrete_files(scenario.scene(case), remark=remark, name=f"{case.rank:02d}.scn")
    return {name: text.encode() for name, text in files.items()}
