"""One case alone as a page."""

from pathlib import Path

from cortex_dsl.page import case_card
from cortex_dsl.page.case import ToldCase
from cortex_dsl.page.document import page
from cortex_dsl.page.element import element
from cortex_dsl.page.player import player_data
from cortex_dsl.report.run_document import first_line
from engine.scenes import StreamKey
from engine.search.ranking import Case


def case_page(told: ToldCase, case: Case | None = None, folder: Path | None = None) -> str:
    """The page of a case; `folder` is that of its run, if it has one."""
    program = told.program
    description = first_line(program.description)
    place = case_card.Place(case or case_of(told), folder)
    body = element(
        "main",
        element(
            "header",
            element("p", "Replay", class_="kicker"),
            element("h1", program.name),
            element("p", description, class_="description") if description else None,
        ),
        case_card.card(told, place, 0),
        class_="film",
    )
    return page(f"{program.name}: replay", body, {"replays": [player_data(told)]}, ("replay.js",))


def case_of(told: ToldCase) -> Case:
    """A single run as a case, where there is no search to rank it."""
    distances = told.outcomes.min_distance[0]
    return Case(
        rank=1,
        row=0,
        rollout=0,
        genome=tuple(told.scenes.genomes[0].tolist()),
        key=StreamKey(*told.scenes.keys[0].tolist()),
        score=told.score,
        continuous=float("nan"),
        collided=bool(told.outcomes.collided[0]),
        min_distance=float(distances.min()) if len(distances) else float("nan"),
    )
