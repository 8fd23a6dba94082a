"""Commands that tell: help, what a name or a code means, what the compiler thinks; and the small settings."""

from collections.abc import Iterator

from rich.text import Text

from cortex_dsl.console.request import assignment
from cortex_dsl.console.terminal import UsageError
from cortex_dsl.diagnostics import Diagnostic
from cortex_dsl.repl.state import LIKE, Desk, check, new_errors
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.terminal.diagnostics_view import print_diagnostics
from cortex_dsl.report.terminal.theme import columns, left
from cortex_dsl.spelling import did_you_mean

ENTERING = """\
Enter statements: each is checked at once, each `require` is weighed on 10,000
draws. A definition replaces the old one of its name; an expression shows what
it is. After a colon, a comma or an open bracket a line goes on; a blank line
ends a block, Escape and Enter end anything."""


def do_help(desk: Desk, argument: str) -> None:
    from cortex_dsl.repl.commands import COMMANDS

    out, name = desk.terminal.out, argument.removeprefix(":")
    if name and name not in COMMANDS:
        raise UsageError(f"there is no command `:{name}`", did_you_mean(name, COMMANDS) or "`:help` lists them all")
    rows = [
        (Text(f":{row.name}", "title"), Text(row.argument, "unit"), Text(row.summary))
        for row in COMMANDS.values()
        if not name or row.name == name
    ]
    if not name:
        out.print(Text(ENTERING), end="\n\n")
    out.print(columns(left(), left(), left(wrap=True), rows=rows))


def do_explain(desk: Desk, argument: str) -> None:
    from cortex_dsl.console.code_pages import main

    main([argument] if argument else [], desk.terminal)


def do_check(desk: Desk, _argument: str) -> None:
    """Everything that is known without drawing."""
    checked, out = desk.checked, desk.terminal.out
    if checked.errors:
        desk.mistakes += 1
    told = (*checked.errors, *(r for r in checked.remarks if checked.compiled is not None))
    if told:
        out.file.flush()
        print_diagnostics(checked.source, told, desk.terminal.err)
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


def do_show(desk: Desk, argument: str) -> None:
    if not argument:
        raise UsageError("what shall be shown?", "a name, a unit or a construct, as in `:show require`")
    text = next((text for text in _texts(desk, argument) if text), "")
    if not text:
        raise UsageError(f"nothing is called `{argument}`", did_you_mean(argument, known(desk)))
    code = False
    for line in text.split("\n"):
        if line.startswith("```"):
            code = not code
        elif line or not code:
            desk.terminal.out.print(line, style="title" if code else "", soft_wrap=not line.count(" "))


def _texts(desk: Desk, word: str) -> Iterator[str]:
    """What is known of a word, the nearest meaning first."""
    from cortex_dsl.editor import hover
    from cortex_dsl.editor.analysis import View, analyse
    from cortex_dsl.semantics.names.builtins import BUILTINS, SPECIAL_NAMES
    from cortex_dsl.semantics.quantities.units import UNITS

    view = View(desk.name, desk.draft.text, analyse(desk.name, desk.draft.text))
    symbol = view.known(len(desk.draft.text)).get(word)
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


def known(desk: Desk) -> list[str]:
    from cortex_dsl.editor.analysis import analyse
    from cortex_dsl.semantics.names.builtins import BUILTINS, PROPERTIES, SPECIAL_NAMES
    from cortex_dsl.semantics.quantities.units import UNITS

    own = (symbol.name for symbol in analyse(desk.name, desk.draft.text).symbols)
    return [*own, *BUILTINS, *SPECIAL_NAMES, *UNITS, *PROPERTIES]


# -- settings ---------------------------------------------------------------------------------------------------------


def do_seed(desk: Desk, argument: str) -> None:
    from cortex_dsl.repl.commands_scenes import seed_of

    if argument:
        desk.seed = seed_of(argument, desk.seed)
        desk.scenes_tried = desk.scenes_shown = 0
        desk.forget_weighings()
    else:
        desk.terminal.out.print(f"seed {desk.seed}")


def do_set(desk: Desk, argument: str) -> None:
    """Hold a param, let it go, or list what is held."""
    from argparse import ArgumentTypeError

    if not argument:
        held = ", ".join(f"{name} = {value}" for name, value in desk.overrides.items())
        desk.terminal.out.print(held or "no param is held; `:set NAME=VALUE` holds one", style="" if held else "quiet")
        return
    if "=" not in argument:
        if argument not in desk.overrides:
            raise UsageError(f"`{argument}` is not held", did_you_mean(argument, desk.overrides))
        _hold(desk, {name: value for name, value in desk.overrides.items() if name != argument})
        return
    try:
        name, value = assignment(argument)
    except ArgumentTypeError as error:
        raise UsageError(f"the setting {error}") from None
    _hold(desk, {**desk.overrides, name: value})


def _hold(desk: Desk, overrides: dict[str, str]) -> None:
    from cortex_dsl.repl.entering import tell_change

    before = desk.checked
    checked = check(desk.draft, desk.name, overrides)
    wrong: tuple[Diagnostic, ...] = new_errors(before, checked)
    if wrong:
        desk.mistakes += 1
        print_diagnostics(checked.source, wrong, desk.terminal.err)
        desk.terminal.err.print("refused: nothing was changed", style="quiet")
        return
    desk.hold(overrides, checked)
    tell_change(desk, before, checked)


def do_quit(desk: Desk, _argument: str) -> None:
    desk.leaving = True
