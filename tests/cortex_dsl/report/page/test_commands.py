"""The command on a page can be typed again."""

import pytest

from cortex_dsl.report.page.markup import command_again


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (("a.scn", "--ga", "--out", "runs/a", "--seed", "3"), "cortexc a.scn --ga --seed 3"),
        (("a.scn", "--out=runs/a", "--random"), "cortexc a.scn --random"),
        (("study", "a b.scn"), "cortexc study 'a b.scn'"),
        (("study",), "cortexc study"),
    ],
)
def test_without_the_folder_that_is_there_by_now(words: tuple[str, ...], line: str) -> None:
    """All but `--out DIR`, quoted for a shell."""
    assert command_again(words) == line
