"""`-p NAME=VALUE`: constants from the command line."""

import pytest

from cortex_dsl import ir
from cortex_dsl.diagnostics import CompileError
from cortex_dsl.semantics.elaboration import elaborate
from cortex_dsl.semantics.names.linking import override_text
from cortex_dsl.semantics.names.tree import param_entries
from cortex_dsl.source import Source
from cortex_dsl.syntax import parse
from engine.vocabulary import Column

TEXT = """map intersection()
param SPEED = Range(5, 80) km/h
param KIND = Uniform('calm', 'hasty')
param N = 3
lane = network.lanes[N]
ego = new Car in lane.centerline, with speed SPEED if KIND == 'calm' else 2 * SPEED
"""


def compiled(**overrides: str) -> ir.Scenario:
    source = Source("test.scn", TEXT)
    return elaborate(parse(source), source, overrides)[0]


def refusal(**overrides: str) -> tuple[str, str]:
    """Code and cure of the first error, as the command line gets it."""
    with pytest.raises(CompileError) as caught:
        compiled(**overrides)
    return caught.value.diagnostics[0].code, caught.value.diagnostics[0].cure


def speed(scenario: ir.Scenario) -> float:
    column = scenario.variants[0].actors[0].columns[Column.SPEED]
    assert isinstance(column, ir.Literal)
    return column.value


@pytest.mark.parametrize("text", ["36", "36 km/h", "10 m/s", "2 * 18"])
def test_bare_number_has_the_unit_of_the_param(text: str) -> None:
    """`-p SPEED=36` means what the file means by 36; a unit of its own is converted."""
    assert speed(compiled(SPEED=text, KIND="calm")) == pytest.approx(10.0, rel=1e-15)


def test_gene_becomes_a_constant() -> None:
    """A param that is set is no longer searched."""
    assert [gene.name for gene in compiled().genes] == ["SPEED", "KIND"]
    assert [gene.name for gene in compiled(SPEED="50").genes] == ["KIND"]
    assert len(compiled(KIND="calm").variants) == 1


@pytest.mark.parametrize("text", ["hasty", "'hasty'", '"hasty"'])
def test_option_may_be_written_without_quotes(text: str) -> None:
    """`-p KIND=hasty` as a shell user writes it."""
    assert speed(compiled(SPEED="36", KIND=text)) == pytest.approx(20.0)


def test_constant_params_can_be_set() -> None:
    """Also those that are no genes."""
    assert len(compiled(N="5").variants) == 2


@pytest.mark.parametrize(
    ("overrides", "code", "cure"),
    [
        ({"SPED": "5"}, "SCN208", "did you mean `SPEED`?"),
        ({"SPEED": "5 m"}, "SCN301", "units of speed: `m/s`, `km/h`, `mph`"),
        ({"KIND": "clam"}, "SCN303", "did you mean `calm`?"),
        ({"SPEED": "Range(1, 2)"}, "SCN506", "use a constant, or a finite choice such as `DiscreteRange`"),
        ({"N": "99"}, "SCN424", "items count from 0: `[0]` to `[19]`; `[-1]` is the last"),
        ({"SPEED": "unknown"}, "SCN201", ""),
    ],
)
def test_bad_value_is_refused(overrides: dict[str, str], code: str, cure: str) -> None:
    """With the reason and a cure."""
    assert refusal(**overrides) == (code, cure)


@pytest.mark.parametrize("text", ["", "1 +", "x = 3", "1\n2", "(" * 50])
def test_value_that_is_no_expression_is_refused(text: str) -> None:
    """Never a crash, whatever the shell passes."""
    code, _ = refusal(SPEED=text)
    assert code == "SCN209" or code.startswith("SCN1")


@pytest.mark.parametrize("text", ["50", "50 km/h", "2 * 25", "13.9 m/s"])
def test_text_for_a_copy_means_the_same(text: str) -> None:
    """A copy of the file that holds the value compiles to the same bits."""
    module = parse(Source("test.scn", TEXT))
    entry = param_entries(module)["SPEED"]
    source = Source("copy.scn", TEXT.replace("Range(5, 80) km/h", override_text(entry, text)))
    copy, _ = elaborate(parse(source), source, {"KIND": "calm"})
    assert speed(copy) == speed(compiled(SPEED=text, KIND="calm"))


SCRIPT = """map intersection()
model scenic.domains.driving.model
ego = new Car on road, with speed globalParameters.velocity
"""


def test_scripts_of_scenic_read_params_of_the_command_line() -> None:
    """In a file with a `model` line `-p` defines a param that the file reads; without it the error says so."""
    source = Source("test.scn", SCRIPT)
    assert speed(elaborate(parse(source), source, {"velocity": "18 km/h"})[0]) == pytest.approx(5.0)
    with pytest.raises(CompileError) as unknown:
        elaborate(parse(source), source, {})
    assert unknown.value.diagnostics[-1].code == "SCN206"
    assert "`-p velocity=5`" in unknown.value.diagnostics[-1].cure


@pytest.mark.parametrize("text", [SCRIPT, SCRIPT.replace("model scenic.domains.driving.model\n", "")])
def test_a_param_that_nothing_reads_is_not_defined(text: str) -> None:
    """A misspelt name is refused in every file, and files without a `model` line define their params themselves."""
    name = "velocit" if text == SCRIPT else "velocity"
    source = Source("test.scn", text)
    with pytest.raises(CompileError) as caught:
        elaborate(parse(source), source, {name: "5"})
    assert caught.value.diagnostics[0].code == "SCN208"
