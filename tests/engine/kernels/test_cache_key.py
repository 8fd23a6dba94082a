"""The key of compiled kernels: it follows what the sources mean, not how they are written."""

import ast
import shutil
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from engine.kernels.jit import KERNEL_INPUTS, KERNELS, syntax_digest, text_digest

Edit = Callable[[str], str]
WORDS: tuple[Edit, ...] = (
    lambda text: f"# A comment.\n\n{text}",
    lambda text: text.replace('"""Return ', '"""Give '),
    lambda text: text.replace("\n\n\n", "\n\n\n\n"),
    lambda text: text.replace("= 0.5", "= (\n    0.5  # half\n)"),
    lambda text: text.replace('    """Return twice."""\n', ""),
)
CODE: tuple[Edit, ...] = (
    lambda text: text.replace("0.5", "0.25"),
    lambda text: text.replace("2.0 * x", "2 * x"),
    lambda text: text.replace("2.0 * x", "x * 2.0"),
    lambda text: text.replace('"ego"', '"Ego"'),
    lambda text: text.replace("@kernel", "@inlined"),
    lambda text: text.replace("return True", "return"),
    lambda text: text.replace("return True", "return 1"),
)
SOURCE = '''"""Return nothing."""
HALF = 0.5
"""A note."""
NAME = "ego"
@kernel
def twice(x):
    """Return twice."""
    return 2.0 * x


def held():
    return True
'''


@pytest.fixture
def kernels(tmp_path: Path) -> Path:
    for name in KERNEL_INPUTS:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(KERNELS.parent / name, tmp_path / name)
    folder = tmp_path / "kernels"
    folder.mkdir()
    (folder / "one.py").write_text(SOURCE)
    return folder


@pytest.mark.parametrize("edit", WORDS)
def test_words_and_layout_are_no_part_of_the_key(kernels: Path, edit: Edit) -> None:
    """Editing a docstring compiles nothing."""
    before = syntax_digest(kernels), text_digest(kernels)
    assert edit(SOURCE) != SOURCE
    (kernels / "one.py").write_text(edit(SOURCE))
    assert syntax_digest(kernels) == before[0]
    assert text_digest(kernels) != before[1]


@pytest.mark.parametrize("edit", CODE)
def test_code_is_part_of_the_key(kernels: Path, edit: Edit) -> None:
    """Each changed constant, type, name, decorator and order."""
    before = syntax_digest(kernels)
    (kernels / "one.py").write_text(edit(SOURCE))
    assert syntax_digest(kernels) != before


@pytest.mark.parametrize("name", KERNEL_INPUTS)
def test_what_kernels_read_is_part_of_the_key(kernels: Path, name: str) -> None:
    """Enum values, columns and names are constants of the machine code."""
    before = syntax_digest(kernels)
    with (kernels.parent / name).open("a") as file:
        file.write("FURTHER = 1\n")
    assert syntax_digest(kernels) != before


def test_subfolders_count_with_their_paths(kernels: Path) -> None:
    """Two files of one name in two folders are two sources, and a moved file is another one."""
    seen = {syntax_digest(kernels)}
    for folder in ("a", "b"):
        (kernels / folder).mkdir()
        (kernels / "one.py").replace(kernels / folder / "one.py")
        seen.add(syntax_digest(kernels))
        (kernels / folder / "one.py").replace(kernels / "one.py")
    assert len(seen) == 3


def test_a_kernel_has_its_name_alone() -> None:
    """Within its module: a compiled entry is found by the module and the name of its function."""
    for path in KERNELS.rglob("*.py"):
        names = Counter(each.name for each in ast.parse(path.read_text()).body if isinstance(each, ast.FunctionDef))
        assert max(names.values(), default=1) == 1, path
