"""`simulation(system=[...])`: the params that belong to the system under test."""

import pytest

from cortex_dsl.diagnostics import CompileError
from cortex_dsl.pipeline import compile_source
from cortex_dsl.source import Source

FILE = """\
map intersection(ways=4, lanes=1)
simulation(system={listed})
param BRAKE = Range(0, 1), SPEED = Range(5, 15) m/s
LIMIT = 3
ego = new Car on road, with speed SPEED * (1 - BRAKE) + LIMIT * 0 m/s
"""


def compiled(listed: str, **overrides: str) -> tuple[str, ...]:
    return compile_source(Source("a.scn", FILE.format(listed=listed)), overrides).program.space.system


def test_names_are_kept_wherever_their_params_stand() -> None:
    """Below the statement too; each once, in the order of the list; as a list or in brackets."""
    assert compiled("[SPEED, BRAKE, SPEED]") == ("SPEED", "BRAKE")
    assert compiled("(BRAKE, SPEED)") == ("BRAKE", "SPEED")
    assert compiled("BRAKE") == ("BRAKE",)
    assert compiled("[]") == ()


def test_a_param_held_fixed_still_belongs_to_the_system() -> None:
    assert compiled("[BRAKE]", BRAKE="0.5") == ("BRAKE",)


@pytest.mark.parametrize(
    ("listed", "cure"),
    [("[BRAKES]", "did you mean `BRAKE`?"), ("[LIMIT]", ""), ('"BRAKE"', ""), ("[BRAKE + 1]", ""), ("5", "")],
)
def test_what_is_no_param_is_reported(listed: str, cure: str) -> None:
    """A misspelt name with its nearest, a constant, a text, a sum, a number."""
    with pytest.raises(CompileError) as caught:
        compiled(listed)
    (problem,) = [d for d in caught.value.diagnostics if d.severity.value == "error"]
    assert problem.code == "SCN483"
    assert cure in problem.cure


def test_the_list_decides_no_result() -> None:
    """It is a name tag: the program's digest stays the same."""
    digests = {
        compile_source(Source("a.scn", FILE.format(listed=listed))).program.digest for listed in ("[BRAKE]", "[]")
    }
    assert len(digests) == 1
