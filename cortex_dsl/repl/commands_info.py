"""Commands that inform: help, meanings of names and codes, diagnostics of the compiler; and the small settings."""

from collections.abc import Iterator

from rich.text import Text

from cortex_dsl.console.request import assignment
from cortex_dsl.console.terminal import UsageError
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.repl.state import LIKE, State, check, new_errors
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.spelling import did_you_mean


def do_explain(state: State, argument: str) -> None:
    from cortex_dsl.console.code_pages import EXPLAIN
    from cortex_dsl.console.command import run_command

    run_command(EXPLAIN, [argument] if argument else [], state.terminal)


def do_check(state: State, _argument: str) -> None:
    """Show all facts that are known without sampling."""
    checked, out = state.checked, state.terminal.out
    if checked.errors:
        state.mistakes += 1
    found = (*checked.errors, *(r for r in checked.remarks if checked.compiled is not None))
    if found:
        out.file.flush()
        print_diagnostics(checked.source, found, state.terminal.err)
    if checked.missing:
        out.print(Text.assemble(("still to come: ", "warn"), f"an ego, {LIKE}"))
    if checked.compiled is None:
        return
    from cortex_dsl.report.terminal.check_view import feasibility_view
    from engine.feasibility import explain

    program = checked.compiled.program
    sizes = ((program.space.names, "param"), (program.actors, "actor"), (program.variants, "variant"))
    words = [counted(len(things), noun) for things, noun in sizes]
    own = sum(r.line > 0 for r in program.requirements)
    out.print(f"compiles: {', '.join((*words, counted(own, 'requirement')))}")
    found = explain(program)
    if found.infeasible:
        names = " and ".join(f"`{program.requirements[r].name}`" for r in found.conflict)
        out.print(Text.assemble(("nothing can hold: ", "bad"), names or "every variant is ruled out"))
    elif (ranges := feasibility_view(program, found)) is not None:
        out.print(ranges)


# -- names ------------------------------------------------------------------------------------------------------------


def do_show(state: State, argument: str) -> None:
    if not argument:
        raise UsageError("what should be shown?", "a name, a unit or a construct, as in `:show require`")
    text = next((text for text in _texts(state, argument) if text), "")
    if not text:
        raise UsageError(f"nothing is called `{argument}`", did_you_mean(argument, known(state)))
    code = False
    for line in text.split("\n"):
        if line.startswith("```"):
            code = not code
        elif line or not code:
            state.terminal.out.print(line, style="title" if code else "", soft_wrap=not line.count(" "))


def _texts(state: State, word: str) -> Iterator[str]:
    """Yield the known meanings of a word, the nearest first."""
    from cortex_dsl.editor import hover
    from cortex_dsl.editor.analysis import View, analyse
    from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES
    from cortex_dsl.semantics.quantities.units import UNITS

    view = View(state.name, state.draft.text, analyse(state.name, state.draft.text))
    symbol = view.known(len(state.draft.text)).get(word)
    if symbol is not None:
        yield hover.symbol_text(view, symbol)
    if word in BUILTINS:
        yield hover.builtin_text(BUILTINS[word])
    if word in SPECIAL_NAMES:
        yield hover.joined(hover.code(word), SPECIAL_NAMES[word])
    if word in UNITS:
        yield hover.unit_text(word)
    yield "\n\n".join(hover.keyword_text(keyword) for keyword in hover.keywords_named(word))
    yield hover.property_text(word)
    if doc := hover.attribute_doc(word):
        yield hover.joined(hover.code(word), doc)


def known(state: State) -> list[str]:
    from cortex_dsl.editor.analysis import analyse
    from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES
    from cortex_dsl.semantics.names.properties import PROPERTIES
    from cortex_dsl.semantics.quantities.units import UNITS

    own = (symbol.name for symbol in analyse(state.name, state.draft.text).symbols)
    return [*own, *BUILTINS, *SPECIAL_NAMES, *UNITS, *PROPERTIES]


# -- settings ---------------------------------------------------------------------------------------------------------


def do_seed(state: State, argument: str) -> None:
    from cortex_dsl.repl.commands_scenes import seed_of

    if argument:
        state.seed = seed_of(argument, state.seed)
        state.scenes_tried = state.scenes_shown = 0
        state.forget_weighings()
    else:
        state.terminal.out.print(f"seed {state.seed}")


def do_set(state: State, argument: str) -> None:
    """Fix a param, release it, or list the fixed ones."""
    from argparse import ArgumentTypeError

    if not argument:
        held = ", ".join(f"{name} = {value}" for name, value in state.overrides.items())
        state.terminal.out.print(held or "no param is held; `:set NAME=VALUE` holds one", style="" if held else "quiet")
        return
    if "=" not in argument:
        if argument not in state.overrides:
            raise UsageError(f"`{argument}` is not held", did_you_mean(argument, state.overrides))
        _hold(state, {name: value for name, value in state.overrides.items() if name != argument})
        return
    try:
        name, value = assignment(argument)
    except ArgumentTypeError as error:
        raise UsageError(f"the setting {error}") from None
    _hold(state, {**state.overrides, name: value})


def _hold(state: State, overrides: dict[str, str]) -> None:
    from cortex_dsl.repl.entering import show_change

    before = state.checked
    checked = check(state.draft, state.name, overrides)
    wrong: tuple[Diagnostic, ...] = new_errors(before, checked)
    if wrong:
        state.mistakes += 1
        print_diagnostics(checked.source, wrong, state.terminal.err)
        state.terminal.err.print("refused: nothing was changed", style="quiet")
        return
    state.hold(overrides, checked)
    show_change(state, before, checked)


def do_quit(state: State, _argument: str) -> None:
    state.leaving = True
