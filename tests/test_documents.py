"""The pages lead where they say: links, options, commands, files and codes that they name exist."""

import re
from pathlib import Path

import pytest

from cortex_dsl.cli.command_table import FILE, SUBCOMMANDS
from cortex_dsl.codes import find
from docs.builder.pages import GENERATED, anchor
from docs.builder.site import LANGUAGE

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [*ROOT.glob("*.md"), *DOCS.rglob("*.md"), ROOT / "examples" / "README.md", ROOT / "benchmarks" / "README.md"]
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
EVERY_PAGE = pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))


def prose(page: Path) -> str:
    """A page without its blocks."""
    return FENCE.sub("", page.read_text(encoding="utf-8"))


@EVERY_PAGE
def test_links_lead_somewhere(page: Path) -> None:
    """To a file of the repository, or a page that only the site has, and to a heading that it has."""
    for target in re.findall(r"\]\((?!https?:)([^)]+)\)", prose(page)):
        name, _, heading = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        if file.is_relative_to(DOCS) and str(file.relative_to(DOCS)).startswith(GENERATED):
            continue
        assert file.exists(), target
        assert not heading or heading in map(anchor, re.findall(r"^#+ (.*)$", prose(file), re.MULTILINE)), target


@EVERY_PAGE
def test_commands_and_codes_exist(page: Path) -> None:
    """`cortexc WORD` is a command or a file, and a code that is named has a page."""
    text = page.read_text(encoding="utf-8")
    for word in re.findall(r"`cortexc ([a-z][\w-]*)\b(?![./])", text):
        assert word in SUBCOMMANDS, word
    for code in re.findall(r"\bSCN\d{3}\b", text):
        assert find(code) is not None, code


@pytest.mark.parametrize("name", [*LANGUAGE, "tutorial/first-collision.md", "how-to/coming-from-scenic.md"])
def test_options_exist(name: str) -> None:
    """Of `cortexc FILE`; what stands with another command is that one's."""
    text = re.sub(r"`cortexc [a-z]+ [^`]*`", "", (DOCS / name).read_text(encoding="utf-8"))
    named = set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text))
    assert named <= {flag for row in FILE.rows for flag in row.flag.split()}


@pytest.mark.parametrize("name", ["ARCHITECTURE.md", "CONTRIBUTING.md"])
def test_files_exist(name: str) -> None:
    """What stands in code marks and looks like a path of ours is one."""
    for path in re.findall(
        r"`((?:cortex_dsl|engine|grammar|docs|editors|examples|tests|benchmarks|kernels|lowering)/[\w/.]*)`",
        prose(ROOT / name),
    ):
        assert any((ROOT / base / path).exists() for base in ("", "engine", "cortex_dsl")), path


@pytest.mark.parametrize(("name", "lines"), [("ARCHITECTURE.md", 150), ("benchmarks/README.md", 150)])
def test_pages_are_short(name: str, lines: int) -> None:
    """A page for readers of one hour has a limit of lines; how a figure or a layout came about is in the log."""
    assert len((ROOT / name).read_text(encoding="utf-8").splitlines()) <= lines
