"""`cortexc verify RUN`: check whether a run is the output of its search, and whether it is reproducible.

With `--model dynamic`: a second opinion on its worst cases, by a better model of the car.
"""

import argparse

from cortex_dsl.api.opinions import MODELS, keep, verify
from cortex_dsl.api.proofs import SAMPLE, Proof, prove, prove_study
from cortex_dsl.api.runs import OpenedRun
from cortex_dsl.cli.search_output import check_past, checked_run, opened_run, usage_errors
from cortex_dsl.console.command import EGO, JOBS, Command, Condition, Option, run_of
from cortex_dsl.console.kernels import SEARCH, compile_kernels
from cortex_dsl.console.request import whole_number
from cortex_dsl.console.terminal import Exit, Terminal
from cortex_dsl.report.findings.readable import counted
from cortex_dsl.report.findings.verification_report import verification_content
from cortex_dsl.report.terminal.render import rendered
from cortex_dsl.report.views.verification import verification_view
from engine.search.ranking import WORST
from engine.strict_json import plain
from engine.study.database import is_study


def _verify(options: argparse.Namespace, terminal: Terminal) -> int:
    return (_journal if options.model is None else _opinion)(options, terminal)


def _journal(options: argparse.Namespace, terminal: Terminal) -> int:
    """The journal itself."""
    if is_study(options.run):
        return _study(options, terminal)
    run = opened_run(options.run, terminal, options.ego, json=options.json)
    check_past(run, terminal)
    compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
    with usage_errors():
        proof = prove(run, options.sample, jobs=options.jobs)
    for remark in proof.remarks:
        terminal.note(remark)
    if options.json:
        terminal.document("proof", {"folder": run.folder, **plain(proof)})
        return Exit.FINE
    for line in _lines(run, proof):
        terminal.out.print(line, soft_wrap=True)
    return Exit.FINE


def _study(options: argparse.Namespace, terminal: Terminal) -> int:
    """All runs of a study, and their evaluations, against its seal."""
    with usage_errors():
        proof = prove_study(options.run)
    for remark in proof.remarks:
        terminal.note(remark)
    if options.json:
        terminal.document("proof", {"folder": options.run, **plain(proof)})
        return Exit.FINE
    size = f"{counted(proof.runs, 'run')}, {counted(proof.evaluations, 'evaluation')}"
    seal = f"the seal holds: {size} as they were written" if proof.proved else f"{size}, unproved"
    terminal.out.print(f"{options.run}\n  {seal}", soft_wrap=True)
    if proof.files:
        terminal.out.print(f"  {_agreeing(proof.files, 'study')}")
    return Exit.FINE


def _agreeing(count: int, source: str) -> str:
    return f"{counted(count, 'file')} beside the {source} follow{'s' * (count == 1)} from it"


def _lines(run: OpenedRun, proof: Proof) -> list[str]:
    size = f"{counted(proof.generations, 'generation')}, {counted(proof.simulations, 'simulation')}"
    chain = f"the chain holds: {size} as they were written" if proof.proved else f"{size}, unproved"
    lines = [f"{run.folder}", f"  {chain}", f"  {proof.text}"]
    if proof.files:
        changed = f"; not so: {', '.join(proof.changed)}" if proof.changed else ""
        lines.append(f"  {_agreeing(proof.files - len(proof.changed), 'journal')}{changed}")
    if proof.differ:
        lines.append(f"  something else came of {proof.first} as {'; '.join(proof.reasons)}")
    return lines


def _opinion(options: argparse.Namespace, terminal: Terminal) -> int:
    """The worst cases, by another model."""
    run = checked_run(options.run, terminal, options.ego, json=options.json)
    compile_kernels(terminal, SEARCH, run.scenario.program, run.scenario.config)
    with usage_errors():
        found = verify(run, options.worst, model=options.model, jobs=options.jobs)
    program = run.scenario.program
    content = plain(verification_content(program, found.cases, found.answers))
    if options.json:
        terminal.document("verification", {"folder": run.folder, **content})
    else:
        view = verification_view(program, found.cases, found.answers)
        terminal.out.print(rendered(view, terminal.out.width, ascii_only=terminal.out.options.ascii_only))
    with usage_errors():
        path = keep(run, content)
    terminal.err.print(f"kept in {path}; `cortexc report` shows it", style="quiet", soft_wrap=True)
    return Exit.FINE if len(found) else Exit.NO_SCENE


_STUDY = Condition("a study, whose seal is checked", lambda options: is_study(options.run))

VERIFY = Command(
    name="verify",
    usage="RUN|STUDY [--sample N] [--jobs N] [--json]\nRUN --model dynamic [--worst N] [--jobs N] [--json]",
    description="""\
Check that the journal of a run is what its search wrote: compare the digests
of all its contents, run a sample of its simulations again, which must give
the same results, bit for bit, and compare the files beside it, which must be
those that follow from it. For a study, check that all runs and evaluations
are as they were written, and compare the files beside it. The exit code is 0
unless something is damaged.

With --model dynamic, repeat the worst cases with a vehicle model whose tyres
slip: which cases survive, which differ, and which are artefacts of the model
or of the time step of the search.""",
    options=(
        run_of("verify"),
        Option(
            "--sample",
            "number of simulations to run again",
            "N",
            whole_number(0, 10**9),
            default=SAMPLE,
            excludes=("model", _STUDY),
        ),
        Option("--model", "dynamic: repeat the worst cases with tyres that slip", "NAME", choices=MODELS),
        Option("--worst", "how many of the worst cases", "N", whole_number(1, 10**6), default=WORST, needs=("model",)),
        JOBS,
        EGO,
    ),
    function=_verify,
)
