"""The gallery: a search of each example for failures of the ego's driver, and one of its ten worst cases as a replay.

The case shown is the one of the ten whose run is the longest.
"""

import ast
import contextlib
import csv
import html
import io
import json
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from cortex_dsl.cli import main
from docs.builder.pages import ROOT

SEARCH = ("--search", "--objective", "avoidable", "--seed", "1")
SECTIONS: dict[str, tuple[str, ...]] = {
    "Twelve strong scenes": (
        "streets/van_at_crossing",
        "streets/child_between_cars",
        "streets/turning_truck",
        "streets/dooring",
        "own_driver/red_light_runner",
        "streets/wet_left_turn",
        "streets/scooter_on_crossing",
        "own_driver/cut_in_and_brake",
        "roads/cyclist_in_roundabout",
        "own_driver/ramp_with_acc",
        "roads/overtaking",
        "own_driver/platoon_with_acc",
    ),
    "A driver of your own": ("own_driver/crossing",),
    "Streets, roundabouts and a village": ("roads/walkers", "roads/roundabout_entry", "roads/village"),
    "Motorways and platoons": ("roads/motorway_cut_in", "roads/on_ramp", "roads/platoon"),
    "Intersections": (
        "left_turn",
        "left_against_crossing",
        "crossing_left_turn",
        "right_and_oncoming_left",
        "right_into_crossing",
        "three_way_left",
    ),
}
"""Examples by the heading under which the page shows them."""
_PLANNER, _ACC = ("--ego", "python:planner:drive"), ("--ego", "python:acc:drive")
DRIVERS = {
    "own_driver/crossing": _PLANNER,
    "own_driver/red_light_runner": _PLANNER,
    "own_driver/cut_in_and_brake": _ACC,
    "own_driver/ramp_with_acc": _ACC,
    "own_driver/platoon_with_acc": _ACC,
}
"""Words that name the driver of an example without one."""
HERO = "left_turn"
"""The example whose replay runs on the landing page."""
LOOP = ROOT / "docs" / "assets" / "loop.html"
"""Added to a replay, it leaves the road alone and plays again and again."""
PAGE = """\
---
hide: [navigation, toc, path]
---

# Gallery

Each example is searched for failures of the ego's driver: `cortexc FILE --search --objective avoidable --seed 1` runs
3,000 simulations and prefers collisions that a competent driver avoids. A picture leads to the replay of one of the ten
worst cases: play it, step through it, read what happened and what the risk is made of. Such a page is one file that
needs no network; `cortexc replay RUN --to case.html` writes it.
"""
SECTION = """
## {title}

<div class="gallery">
{cards}
</div>
"""
CARD = """\
<a class="film" href="{name}.html"><img src="{name}.svg" alt="The road and the actors where they meet" loading="lazy">
<span class="film-title">{kind}{name}</span>
<span class="film-text">{text}</span>
<span class="film-facts">{collisions:,} different collisions found, {avoidable:,} of them avoidable</span></a>"""


@dataclass(frozen=True)
class Film:
    """The case of one example."""

    name: str
    section: str
    title: str
    """The docstring of the file."""
    collisions: int
    """Number of colliding runs of the search; no two are alike."""
    avoidable: int
    """Number of these that a competent driver avoids."""
    page: str
    """The replay, one self-contained HTML page."""
    picture: str
    """The road and the actors at the moment that the page opens with, as SVG."""
    why: str = ""
    """The reason for the example and its driver, from the docstring."""

    @property
    def loop(self) -> str:
        """The replay without its tables and buttons, which plays by itself."""
        return self.page.replace("</body>", LOOP.read_text(encoding="utf-8") + "</body>")


def films() -> Iterator[Film]:
    """Yield one film per example, in the order of the page."""
    for section, examples in SECTIONS.items():
        for example in examples:
            yield _film(section, ROOT / "examples" / f"{example}.scn", DRIVERS.get(example, ()))


def _film(section: str, path: Path, driver: Sequence[str]) -> Film:
    """Search an example from its own folder, where its maps and drivers are, and return its film."""
    with (
        tempfile.TemporaryDirectory() as scratch,
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.chdir(path.parent),
    ):
        run, replay, picture = (Path(scratch) / name for name in ("run", "replay.html", "picture.svg"))
        main([path.name, *SEARCH, *driver, "--out", str(run), "--json"])
        summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
        with (run / "evaluations.csv").open(encoding="utf-8", newline="") as table:
            ends = {row["key"]: float(row["end_time"] or 0) for row in csv.DictReader(table)}
        case = max(summary["worst"], key=lambda each: ends[each["key"]])
        for target in (replay, picture):
            main(["replay", str(run), "--case", str(case["rank"]), "--to", str(target)])
        page, drawing = (target.read_text(encoding="utf-8") for target in (replay, picture))
    title, _, why = _docstring(path.read_text(encoding="utf-8")).partition("\n\n")
    failures = summary["failures"]
    counts = failures["collisions"], failures["avoidable"]
    return Film(path.stem, section, " ".join(title.split()), *counts, page, drawing, " ".join(why.split()))


def _docstring(text: str) -> str:
    """Return the docstring of a file, which begins with it."""
    return str(ast.literal_eval(text[: text.index('"""', 3) + 3])).strip()


def page(found: Sequence[Film]) -> str:
    """Return the page: a card for each film, under the heading of its section."""
    cards: dict[str, list[str]] = {}
    for film in found:
        kind, colon, what = film.title.rpartition(": ")
        text = html.escape(what[:1].upper() + what[1:])
        cards.setdefault(film.section, []).append(
            CARD.format(
                name=film.name,
                kind=html.escape(kind + " · ") if colon else "",
                text=f"{text} {html.escape(film.why)}".strip(),
                collisions=film.collisions,
                avoidable=film.avoidable,
            )
        )
    return PAGE + "".join(SECTION.format(title=title, cards="\n".join(each)) for title, each in cards.items())
