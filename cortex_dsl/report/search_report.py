"""What the views of a search are given: the campaign, and where its results lie."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.search.run import Campaign


@dataclass(frozen=True)
class SearchReport:
    """One campaign and its traces on disk."""

    campaign: Campaign
    folder: Path | None
    worst_files: Sequence[Path] = ()
    """Concrete scenarios of the worst cases, in their order; fewer where some could not be written."""

    name: str = ""
    """Of the method, where it is not one of ours."""

    @property
    def method(self) -> str:
        return self.name or self.campaign.method
