"""Lay a page of the repository out for the site: its links, headings and blocks, as Zensical reads them.

The pages are written for readers of the repository, too: links lead from file to file, and headings have the names that
code hosts give them. The words of a fence (```` ```scn first.scn + ````) are for the tests.
"""

import posixpath
import re
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[2]
OF_THE_ROOT = {
    "README.md": "index.md",
    "examples/README.md": "tutorial/examples.md",
    "benchmarks/README.md": "explanation/measured.md",
    "ARCHITECTURE.md": "explanation/architecture.md",
    "CONTRIBUTING.md": "explanation/contributing.md",
    "CHANGELOG.md": "reference/changelog.md",
}
"""Pages outside of docs/, and where they stand in the site. The landing page is docs/index.md; links to the README lead
there."""
GENERATED = ("gallery/", "reference/commands.md", "reference/diagnostics/")
"""Places in docs/ that only the site has."""
FENCE = re.compile(r"^```(?P<info>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\[(?P<text>[^\]]*)\]\((?!https?:)(?P<target>[^)#]*)(?P<heading>#[^)]*)?\)")
CODE = re.compile(r"(?<!\[)`(SCN\d{3})`(?!\])")
HEADING = re.compile(r"^(#+) (.*)$", re.MULTILINE)
LANGUAGES = {"": "text", "scn-error": "scn"}
"""Words of a fence that are no language of the highlighter."""


def sources() -> dict[str, str]:
    """Path in the repository of every page, and its place in the site."""
    own = {str(path.relative_to(ROOT)): str(path.relative_to(ROOT / "docs")) for path in (ROOT / "docs").rglob("*.md")}
    return {name: place for name, place in (OF_THE_ROOT | own).items() if name != "README.md"}


def anchor(heading: str) -> str:
    """The name under which a heading can be linked to, as code hosts make it."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


def laid_out(name: str, text: str) -> str:
    """The page of that path, for the site."""
    place = sources()[name]
    return outside_blocks(text, lambda prose: _codes(_links(_headings(prose), name, place), place), _block)


def outside_blocks(text: str, prose: Callable[[str], str], block: Callable[[re.Match[str]], str]) -> str:
    """A page whose prose and whose blocks are each changed in their own way."""
    parts, end = [], 0
    for match in FENCE.finditer(text):
        parts += [prose(text[end : match.start()]), block(match)]
        end = match.end()
    return "".join([*parts, prose(text[end:])])


def _block(match: re.Match[str]) -> str:
    """A block with its language alone, and its file's name as a title."""
    language, *words = match["info"].split() or [""]
    language = LANGUAGES.get(language, language)
    title = next((f' title="{word}"' for word in words if "." in word), "")
    if words and words[0].startswith("SCN"):
        title = f' title="{words[0]}"'
    return f"```{language}{title}\n{match['text']}```"


def _headings(prose: str) -> str:
    """Headings with the names that links use."""
    return HEADING.sub(lambda match: f"{match[0]} {{ #{anchor(match[2])} }}", prose)


def _links(prose: str, name: str, place: str) -> str:
    """Links from page to page of the site; what leads to a file that is no page keeps its words alone."""

    def link(match: re.Match[str]) -> str:
        target, heading = match["target"], match["heading"] or ""
        if not target:
            return match[0]
        page = _place(posixpath.normpath(posixpath.join(posixpath.dirname(name), target)))
        if page is None:
            return match["text"]
        return f"[{match['text']}]({posixpath.relpath(page, posixpath.dirname(place) or '.')}{heading})"

    return LINK.sub(link, prose)


def _place(name: str) -> str | None:
    """Where a file of the repository stands in the site; None where it is no page."""
    generated = name.removeprefix("docs/")
    if generated.startswith(GENERATED):
        return generated
    return (sources() | {"README.md": "index.md"}).get(name)


def _codes(prose: str, place: str) -> str:
    """A code that is named leads to its page."""
    home = posixpath.relpath("reference/diagnostics", posixpath.dirname(place) or ".")
    return CODE.sub(rf"[`\1`]({home}/\1.md)", prose)
