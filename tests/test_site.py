"""The site: every page, command and code has its place in it, and no link of it leads nowhere."""

import json
import posixpath
import re
from html.parser import HTMLParser
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest

from cortex_dsl.cli.command_table import SUBCOMMANDS
from cortex_dsl.codes import entries
from docs.builder import gallery, program
from docs.builder.pages import GENERATED, OF_THE_ROOT, ROOT, anchor, laid_out, sources
from docs.builder.site import build, navigation, stage

EXAMPLES = sorted((ROOT / "examples").rglob("*.scn"))


def listed(entry: Any) -> list[str]:
    """Places that a part of the navigation names."""
    if isinstance(entry, str):
        return [entry]
    inner = entry.values() if isinstance(entry, dict) else entry
    return [place for each in inner for place in listed(each)]


def test_every_page_has_its_place() -> None:
    """Each page of the repository and each generated one stands once in the navigation, and nothing else does."""
    places = listed(navigation())
    assert len(places) == len(set(places))
    generated = {"gallery/index.md", "reference/commands.md", *program.diagnostics()}
    assert set(places) == {*sources().values(), *generated}
    assert all(place.startswith(GENERATED) for place in generated)
    assert set(OF_THE_ROOT) - {"README.md"} <= set(sources())


def test_every_code_and_command_has_its_page() -> None:
    """The pages come from what `explain` and `--help` print."""
    pages = program.diagnostics()
    for entry in entries():
        text = pages[program.place(entry.code)]
        assert text.count(f"# {entry.code}: ") == 1
        assert f'class="badge {entry.severity.value}"' in text
    commands = program.commands()
    for name in SUBCOMMANDS:
        assert f"## cortexc {name}\n" in commands
        assert program.said(name, "--help").rstrip() in commands


def test_the_gallery_shows_every_example() -> None:
    """Each example has its card on the page, unless it needs a map from elsewhere or repeats another."""
    examples = {path.relative_to(ROOT / "examples").with_suffix("").as_posix(): path for path in EXAMPLES}
    shown = [example for section in gallery.SECTIONS.values() for example in section]
    assert len(shown) == len(set(shown))
    others = {each for each in set(examples) - set(shown) if not each.startswith("paper/")}
    assert others == {"roads/left_turn_in_town"}
    assert {*gallery.DRIVERS, gallery.HERO} <= set(shown)
    films = [
        gallery.Film(example, section, f"A road: <{example}>", 1234, 56, "", "")
        for section, held in gallery.SECTIONS.items()
        for example in held
    ]
    page = gallery.page(films)
    assert re.findall(r"^## (.*)$", page, re.MULTILINE) == [*gallery.SECTIONS]
    assert re.findall(r'href="(.*?)\.html"', page) == shown
    assert "A road · left_turn" in page
    assert "&lt;left_turn&gt;" in page
    assert "1,234 different collisions found, 56 of them avoidable" in page


def test_a_page_is_laid_out_for_the_site() -> None:
    """Links go to places of the site, those that leave it keep their words, codes lead to their pages."""
    text = laid_out(
        "docs/tutorial/first-collision.md",
        "# A road!\n\n[The README](../../README.md), [rules](../reference/language.md#on-the-run), "
        "[law](../../LICENSE); `SCN203`\n"
        "\n```scn first.scn +\n# [no](link.md) `SCN203`\n```\n",
    )
    assert text.startswith("# A road! { #a-road }\n")
    assert "[The README](../index.md), [rules](../reference/language.md#on-the-run), law;" in text
    assert "[`SCN203`](../reference/diagnostics/SCN203.md)" in text
    assert '```scn title="first.scn"\n# [no](link.md) `SCN203`\n```' in text
    assert anchor("What `cortexc` says: 1, 2") == "what-cortexc-says-1-2"


def test_staged_links_lead_somewhere(tmp_path: Path) -> None:
    """Every link of every page to another one, before anything makes HTML of them."""
    stage(tmp_path, with_gallery=False)
    pages = tmp_path / "docs"
    for page in pages.rglob("*.md"):
        prose = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\((?!https?:)([^)#]+)", prose):
            place = Path(posixpath.normpath(page.parent / target))
            assert place.is_relative_to(pages / "gallery") or place.exists(), f"{page}: {target}"


class Anchors(HTMLParser):
    """Links and names of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.names.add(given.get("id") or "")
        for name in ("href", "src"):
            if tag in ("a", "link", "script", "img") and (target := given.get(name)):
                self.links.append(target)


@pytest.mark.skipif(find_spec("zensical") is None, reason="zensical is not installed")
def test_the_site_is_built(tmp_path: Path) -> None:
    """Without replays: no link leads nowhere, nothing is fetched from elsewhere, and the search knows every code."""
    site = tmp_path / "site"
    assert build(site, gallery=False) == 0
    pages = {path.relative_to(site): Anchors(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}
    for page, found in pages.items():
        for link in found.links:
            if "://" in link or page.name == "404.html":
                assert "fonts.g" not in link, link
                continue
            target, _, name = unquote(link).partition("#")
            place = Path(posixpath.normpath(page.parent / target)) if target else page
            if place.parts[0] == "gallery":
                continue
            assert (site / place).exists(), f"{page}: {link}"
            assert not name or place not in pages or name in pages[place].names, f"{page}: {link}"
    index = json.dumps(json.loads((site / "search.json").read_text(encoding="utf-8")))
    assert all(entry.code in index for entry in entries())


def test_the_builder_is_no_part_of_a_package() -> None:
    """Nothing of the site is imported by what is installed."""
    for package in ("cortex_dsl", "engine"):
        for module in (ROOT / package).rglob("*.py"):
            assert "docs.builder" not in module.read_text(encoding="utf-8"), module
