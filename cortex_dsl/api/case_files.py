"""Cases of a search as scenarios of their own, in the run's folder: the worst, and those over which the driver failed.

| folder    | holds                                                                        |
|-----------|------------------------------------------------------------------------------|
| worst/    | the worst cases, which run to the same outcome                               |
| failures/ | the first scenes over which a controller failed, to be driven again by it    |
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from cortex_dsl.api.concrete import map_copies
from engine.config import Config
from engine.program import Program
from engine.search.campaign import Campaign
from engine.search.ranking import Case, lost_cases
from engine.search.store import store_errors

if TYPE_CHECKING:
    from engine.scenes import Scenes

WORST_FOLDER, FAILURE_FOLDER = "worst", "failures"


class Writable(Protocol):
    """What writing a case asks of a scenario."""

    @property
    def program(self) -> Program: ...
    @property
    def config(self) -> Config: ...
    def scene(self, case: Case) -> "Scenes": ...
    def driven_by(self, ego: object, /) -> "Writable": ...
    def concrete_files(self, scenes: "Scenes", row: int = 0, remark: str = "", name: str = "") -> dict[str, str]: ...


def worst_files(folder: Path) -> list[Path]:
    """The scenarios of the worst cases, in their order."""
    return _files(folder / WORST_FOLDER)


def write_cases(scenario: Writable, folder: Path, campaign: Campaign, file: str) -> list[Path]:
    """Write the cases of a search in `file`, and remove those that were there before the run went on; return the files
    of the worst.

    Raises:
        StoreError: a file cannot be written.
    """
    # whoever drives again decides again
    undriven = scenario if scenario.config.driver is None else scenario.driven_by(None)
    _write(undriven, folder / FAILURE_FOLDER, lost_cases(campaign.evaluations), file)
    return _write(undriven, folder / WORST_FOLDER, campaign.worst, file)


def _files(folder: Path) -> list[Path]:
    return sorted(folder.glob("[0-9][0-9].scn"))


def _write(scenario: Writable, folder: Path, cases: Sequence[Case], file: str) -> list[Path]:
    written = [_write_case(scenario, folder, case, file) for case in cases]
    with store_errors(folder):
        for path in set(_files(folder)) - set(written):
            path.unlink()
    return written


def _write_case(scenario: Writable, folder: Path, case: Case, file: str) -> Path:
    what = "the driver failed" if case.lost else f"risk {case.score}"
    remark = f"case {case.rank} of a search in {file}: {what}"
    path = folder / f"{case.rank:02d}.scn"
    files = scenario.concrete_files(scenario.scene(case), remark=remark, name=path.name)
    with store_errors(path):
        path.parent.mkdir(exist_ok=True)
        for name, text in files.items():
            path.with_name(name).write_text(text, encoding="utf-8")
        for name, content in map_copies(scenario.program).items():
            if not (copy := path.with_name(name)).exists():
                copy.write_bytes(content)
    return path
