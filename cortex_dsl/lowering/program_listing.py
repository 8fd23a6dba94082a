"""A program as a readable listing: its contents, and its code with named registers, as in an assembler listing.

Names of registers show their contents: `=2.5` a literal, `v0` a variant value, `g0` a gene, `d0` a draw, `t0` a
temporary of scene code; `s0` a scene value, `r0` a local or temporary of step code. Operands that are no registers are
bare; jumps name rows.
"""

from collections.abc import Callable, Iterator, Sequence

from engine.opcodes import Op
from engine.operators import signature
from engine.program import Program
from engine.tables import Size
from engine.vocabulary import ActorKind, Column, Command, GeneKind, State, TemporalOp, Turns

Namer = Callable[[int], str]

OF_ACTORS = frozenset(
    {Op.STATE, Op.WITHIN, Op.LEAD, Op.TTC, Op.SPAWN, Op.SEES, Op.NOTICES, Op.TOUCHES, Op.VELOCITY, Op.CROSSING}
)
"""Their plain operands are actors (of STATE the first)."""


def format_program(program: Program) -> str:
    """The whole listing."""
    return "\n".join(
        [
            *_head(program),
            *_variants(program),
            *_scene_code(program),
            *_step_code(program),
        ]
    )


def _head(program: Program) -> Iterator[str]:
    yield f"program {program.name}  digest {program.digest}"
    for index, name in enumerate(program.space.names):
        low, high, unit = program.space.low[index], program.space.high[index], program.space.units[index]
        kind = GeneKind(program.space.kinds[index]).name.lower()
        yield f"gene g{index} {name}: {kind} {low:g} .. {high:g} {unit}".rstrip()
    for index, (name, kind) in enumerate(zip(program.actors, program.code.actor_kind, strict=True)):
        absent = "" if program.code.actor_present[index] else ", absent at the start"
        yield f"actor {index} {name}: {ActorKind(kind).name.lower()}{absent}"
    for index, name in enumerate(program.monitors):
        yield f"monitor {index} {name}{Turns(program.code.monitor_started[index]).words}"
    for index, requirement in enumerate(program.requirements):
        yield f"requirement {index} {requirement.name!r} (line {requirement.line or '-'})"
    for index, rule in enumerate(program.rules):
        yield f"rule {index} {rule.name!r} (line {rule.line}): {rule.kind.name.lower()}"
    for root, rule in zip(program.code.temporal_root, program.code.temporal_rule, strict=True):
        yield f"requirement {_formula(program, root)}, else rule {rule}"
    for record in program.records:
        yield f"record {record.when} {record.name!r}: rule {record.rule} {record.unit}".rstrip()
    for number, reading in enumerate(program.judged.readings):
        yield f"reading r{number}: {reading.kind.name.lower()} {reading.result or f'rule {reading.rule}'}"
    for objective, root in zip(program.judged.objectives, program.judged.tables.root, strict=True):
        formula = f": {_formula(program, root)}" if root >= 0 else f" {objective.unit}".rstrip()
        yield f"{objective.sense.name.lower()} {objective.name!r}{formula}"
    road = program.road
    yield f"road: {len(road.path_length)} paths, {len(road.lane_path)} lanes, {len(road.region_start) - 1} regions"


def _formula(program: Program, row: int) -> str:
    """A temporal formula in words; an operand that is no atom in parentheses."""
    op, *operands = program.code.formula[row].tolist()
    if op == TemporalOp.ATOM:
        return f"rule{operands[0]}" if operands[1] < 0 else f"rule{operands[0]}/{operands[1]}"
    word = TemporalOp(op).name.lower()
    texts = [_formula(program, operand) for operand in operands if operand >= 0]
    first, *second = [f"({text})" if " " in text else text for text in texts]
    return f"{first} {word} {second[0]}" if second else f"{word} {first}"


def _variants(program: Program) -> Iterator[str]:
    yield ""
    yield "variants"
    for index, variant in enumerate(program.variants):
        template = int(program.code.variant_template[index])
        chosen = ", ".join(f"{choice.name} = {choice.option}" for choice in variant.choices) or "no choices"
        code = f"template {template}" if template >= 0 else "impossible"
        values = " ".join(f"v{i}={value:g}" for i, value in enumerate(program.code.variant_values[index]))
        yield f"  {index:3}  p {variant.probability:.4g}  {code}  {chosen}  {values}".rstrip()


def _scene_code(program: Program) -> Iterator[str]:
    code = program.code
    genes, draws = len(program.space), int(code.sizes[Size.DRAWS])
    name = _namer(program, [("g", genes), ("d", draws), ("t", -1)])
    for template in range(len(code.output_segment)):
        yield ""
        yield f"template {template}: scene"
        for index, (start, end, result) in enumerate(code.requirement_segment[template].tolist()):
            yield f" requirement {index} -> {name(result)}"
            yield from _rows(code.scene_code[start:end].tolist(), start, name)
        start, end = code.output_segment[template].tolist()
        yield " outputs"
        yield from _rows(code.scene_code[start:end].tolist(), start, name)
        yield from _outputs(program, template, name)


def _outputs(program: Program, template: int, name: Namer) -> Iterator[str]:
    columns = len(Column)
    for index, register in enumerate(program.code.output_register[template].tolist()):
        actor, column = divmod(index, columns)
        of = f"  {program.actors[actor]}.{Column(column).name.lower()}" if actor < len(program.actors) else ""
        yield f"        s{index} <- {name(register)}{of}"


def _step_code(program: Program) -> Iterator[str]:
    code = program.code
    name = _namer(program, [("s", int(code.sizes[Size.SCENE_VALUES])), ("r", -1)])
    for template in range(len(code.output_segment)):
        yield ""
        yield f"template {template}: step"
        for index, (start, end, result) in enumerate(code.rule_segment[template].tolist()):
            if start >= 0:
                yield f" rule {index} -> {name(result)}"
                yield from _rows(code.step_code[start:end].tolist(), start, name)
        for index, (start, end, result) in enumerate(program.judged.tables.segment[template].tolist()):
            if start >= 0:
                yield f" objective {index} -> {name(result)}"
                yield from _rows(code.step_code[start:end].tolist(), start, name)
        for monitor, entry in enumerate(code.monitor_entry[template].tolist()):
            yield f" monitor {program.monitors[monitor]}, block {code.monitor_block[template, monitor]}"
            yield from _coroutine(program, entry, name)
        for actor, entry in enumerate(code.behaviour_entry[template].tolist()):
            if entry >= 0:
                yield f" behaviour of {program.actors[actor]}, block {code.main_block[template, actor]}"
                yield from _coroutine(program, entry, name)


def _coroutine(program: Program, entry: int, name: Namer) -> Iterator[str]:
    """Yield its rows up to its only HALT, which is the last row."""
    rows = program.code.step_code[entry:].tolist()
    end = next(i for i, row in enumerate(rows) if row[0] == Op.HALT)
    lines = program.step_lines[entry : entry + end + 1].tolist()
    yield from _rows(rows[: end + 1], entry, name, [program.place(line) for line in lines])


def _namer(program: Program, groups: Sequence[tuple[str, int]]) -> Namer:
    """Names of the registers of one file: literals, variant values, then the groups (letter, count; -1: the rest)."""
    literals = program.code.literals.tolist()
    everything = [("v", program.code.variant_values.shape[1]), *groups]

    def name(register: int) -> str:
        if register < len(literals):
            return f"={literals[register]:g}"
        register -= len(literals)
        for letter, count in everything:
            if count < 0 or register < count:
                return f"{letter}{register}"
            register -= count
        raise AssertionError("the last group takes the rest")

    return name


def _rows(rows: Sequence[Sequence[int]], first: int, name: Namer, lines: Sequence[str] = ()) -> Iterator[str]:
    for index, row in enumerate(rows):
        text = f"  {first + index:4}  {_instruction(row, name)}"
        yield f"{text:<56}; line {lines[index]}" if lines else text


def _instruction(row: Sequence[int], name: Namer) -> str:
    op, destination, operands = Op(row[0]), row[1], row[2:]
    counts, results = signature(op)
    words = [
        name(operand) if count else _plain(op, position, operand)
        for position, (operand, count) in enumerate(zip(operands, counts, strict=False))
    ]
    body = f"{op.name.lower():16} {', '.join(words)}".rstrip()
    return f"{name(destination):5} <- {body}" if results else body


def _plain(op: Op, position: int, operand: int) -> str:
    """Return a literal operand, as a word if it has one."""
    if op == Op.STATE and position == 1:
        return State(operand).name.lower()
    if op == Op.TTC and position == 2:
        return "noticed" if operand else "any"
    if op in OF_ACTORS:
        return f"actor {operand}" if operand >= 0 else "anybody"
    if op == Op.COMMAND:
        return Command(operand).name.lower()
    return str(operand)
