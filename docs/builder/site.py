"""Put the site together: lay the pages out in a folder, say where each stands, and let Zensical make it."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from docs.builder import gallery, program
from docs.builder.pages import ROOT, laid_out, sources

CONFIG = ROOT / "docs" / "zensical.toml"
LANGUAGE = (
    "reference/language.md",
    "reference/language/files-and-values.md",
    "reference/language/operators.md",
    "reference/language/roads.md",
    "reference/language/road-files.md",
    "reference/language/streets.md",
    "reference/language/road-attributes.md",
    "reference/language/params.md",
    "reference/language/objects.md",
    "reference/language/sight.md",
    "reference/language/behaviors.md",
    "reference/language/library.md",
    "reference/language/requirements.md",
    "reference/language/objectives.md",
    "reference/language/traffic-lights.md",
    "reference/language/composition.md",
    "reference/language/runs.md",
)
"""Pages on the language, in the order of reading; the first one lists the others."""
REFERENCE = (
    "reference/overview.md",
    "reference/commands.md",
    "reference/python.md",
    "reference/metrics.md",
    "reference/drivers.md",
    "reference/suites.md",
    "reference/scenic.md",
    "reference/changelog.md",
)


def build(folder: Path, *, gallery: bool = True) -> int:
    """Build the site into a folder; the exit code of Zensical."""
    staged = folder.with_name(folder.name + "-pages")
    stage(staged, with_gallery=gallery)
    (staged / "zensical.toml").write_text(
        CONFIG.read_text(encoding="utf-8").replace("nav = []", f"nav = {_toml(navigation())}"),
        encoding="utf-8",
    )
    done = subprocess.run([sys.executable, "-m", "zensical", "build", "--clean", "--strict"], cwd=staged, check=False)
    if done.returncode == 0:
        shutil.rmtree(folder, ignore_errors=True)
        shutil.move(staged / "site", folder)
        sys.stdout.write(
            f"{folder / 'index.html'}: written; `python -m http.server -d {folder}` shows it, search included\n"
        )
    return done.returncode


def stage(folder: Path, *, with_gallery: bool = True) -> None:
    """Every page, laid out for the site, under `folder/docs`."""
    shutil.rmtree(folder, ignore_errors=True)
    target = folder / "docs"
    for name, place in sources().items():
        _write(target / place, laid_out(name, (ROOT / name).read_text(encoding="utf-8")))
    _write(target / "reference/commands.md", program.commands())
    for place, text in program.diagnostics().items():
        _write(target / place, text)
    shutil.copytree(ROOT / "docs" / "assets", target / "assets")
    films = [*gallery.films()] if with_gallery else []
    _write(target / "gallery/index.md", gallery.page(films))
    for film in films:
        _write(target / f"gallery/{film.name}.html", film.page)
        _write(target / f"gallery/{film.name}.svg", film.picture)
        if film.name == gallery.HERO:
            _write(target / "gallery/hero.html", film.loop)


def navigation() -> list[dict[str, Any]]:
    """Title and place of every page, section by section."""
    codes = [
        {family.capitalize(): [{f"{code['code']} {code['title']}": program.place(code["code"])} for code in found]}
        for family, found in program.families().items()
    ]
    return [
        {"Home": "index.md"},
        {"Tutorial": _section("tutorial", "tutorial/first-collision.md")},
        {"Gallery": ["gallery/index.md"]},
        {"How to": _section("how-to", "how-to/search.md")},
        {
            "Reference": [
                {"Language": [*LANGUAGE]},
                *REFERENCE,
                {"Diagnostics": ["reference/diagnostics/index.md", *codes]},
            ]
        },
        {
            "Explanation": _section(
                "explanation", *(f"explanation/{page}.md" for page in ("risk", "avoidability", "search-against-chance"))
            )
        },
    ]


def _section(name: str, *first: str) -> list[str]:
    found = sorted(place for place in sources().values() if place.startswith(f"{name}/"))
    return [*first, *(place for place in found if place not in first)]


def _toml(value: Any) -> str:
    """Lists, tables and text as TOML writes them."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_toml(name)} = {_toml(inner)}" for name, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[\n" + "".join(f"{_toml(inner)},\n" for inner in value) + "]"
    return json.dumps(value.replace("`", ""), ensure_ascii=False)


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
