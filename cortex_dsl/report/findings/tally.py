"""Counts over sampled scenes: verdicts, attempts, tests and failures of each requirement.

Derived from them: the first culprit, the effect of each requirement alone and its nearest miss, a relaxation, and
contradictions between requirements.
"""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from cortex_dsl.report.findings.readable import ABSENT, counted, format_gene, gene_value, percent, ratio, significant
from engine.program import Program
from engine.vocabulary import Verdict

if TYPE_CHECKING:
    from engine.acceptance import Account, Blame
    from engine.scenes import Scenes
    from engine.search.evaluations import Evaluations


Counts = NDArray[np.int64]


def _zeros() -> Counts:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True)
class Tally:
    """Sums over scenes; two tallies of the same program add up."""

    scenes: int = 0
    verdicts: Counts = field(default_factory=lambda: np.zeros(len(Verdict), dtype=np.int64))
    """(len(Verdict),)"""
    attempts: int = 0
    tested: Counts = field(default_factory=_zeros)
    """(requirements,)"""
    failed: Counts = field(default_factory=_zeros)
    """(requirements,) of those tested; a requirement is only tested where the earlier ones passed."""
    long: int = 0
    """Scenes that needed more than `FREE_ATTEMPTS`: with `--prune`, those that went on in bounds."""

    def plus(self, scenes: "Scenes") -> "Tally":
        from engine.sampling import FREE_ATTEMPTS

        tested, failed = scenes.tested.sum(axis=0, dtype=np.int64), scenes.failed.sum(axis=0, dtype=np.int64)
        went_on = (scenes.attempts > FREE_ATTEMPTS) | ((scenes.attempts == FREE_ATTEMPTS) & ~scenes.valid)
        return Tally(
            self.scenes + len(scenes),
            self.verdicts + np.bincount(scenes.verdict, minlength=len(Verdict)),
            self.attempts + int(scenes.attempts.sum()),
            tested + (self.tested if self.tested.size else 0),
            failed + (self.failed if self.failed.size else 0),
            self.long + int(went_on.sum()),
        )

    @classmethod
    def of_search(cls, evaluations: "Evaluations") -> "Tally":
        """Every distinct simulation of a search."""
        runs, new = evaluations.rollouts, ~evaluations.reused
        verdicts = np.bincount(runs.verdict[new].ravel(), minlength=len(Verdict))
        tested, failed = (counts[new].sum(axis=(0, 1), dtype=np.int64) for counts in (runs.tested, runs.failed))
        return cls(int(verdicts.sum()), verdicts, int(runs.attempts[new].sum()), tested, failed)

    @property
    def valid(self) -> int:
        return int(self.verdicts[Verdict.VALID])

    @property
    def always(self) -> bool:
        """Return whether every attempt was accepted."""
        return self.valid == self.attempts

    @property
    def acceptance(self) -> float:
        """Accepted attempts of all attempts; NaN without any."""
        return ratio(self.valid, self.attempts)

    def pass_rate(self, requirement: int) -> float:
        tested = int(self.tested[requirement])
        return 1.0 - int(self.failed[requirement]) / tested if tested else math.nan


def first_culprit(program: Program, tally: Tally) -> int | None:
    """Return the requirement to inspect first: the first that never passed, else the one with the lowest rate."""
    rated = [
        (tally.pass_rate(i), i) for i in range(min(len(program.requirements), len(tally.failed))) if tally.failed[i] > 0
    ]
    never = [index for rate, index in rated if rate == 0.0]
    return never[0] if never else min(rated)[1] if rated else None


def most_to_blame(program: Program, tally: Tally, account: "Account | None") -> int | None:
    """Return the requirement without which most attempts would pass, or the tally's culprit where there is no account.

    In the tally, a draw of the params counts once where it is proved hopeless, else as often as it was tried.
    """
    failing = [] if account is None else [b for b in account.blames if b.alone < 1.0 and tally.failed[b.requirement]]
    return max(failing, key=lambda blame: blame.without).requirement if failing else first_culprit(program, tally)


# -- which requirement throws attempts away ----------------------------------------------------------------------------

MOST_PARAMS = 4
"""Params of a nearest miss that are shown at most."""


def blame_note(account: "Account") -> str:
    """Return the total that the shares in the table refer to."""
    weighing = account.weighing
    met = f"{percent(weighing.acceptance, 2)} met all"
    own = " with new params" if len(weighing.program.space) else ""
    return f"{counted(len(weighing), 'single attempt')}{own}, each tested against all requirements; {met}"


def missed_by(account: "Account", blame: "Blame") -> str:
    return ABSENT if blame.nearest < 0 else amount_text(account, blame.requirement, _shortfall(account, blame))


def _shortfall(account: "Account", blame: "Blame") -> float:
    return -float(account.weighing.margins[blame.nearest, blame.requirement])


def amount_text(account: "Account", requirement: int, amount: float) -> str:
    """Return an amount in the unit that the file uses for its dimension."""
    row = account.weighing.program.requirements[requirement]
    return f"{significant(amount / row.display_scale, 3)} {row.display_unit or row.unit}".rstrip()


def params_of_miss(account: "Account", blame: "Blame") -> str:
    """The params that the requirement depends on, in that attempt."""
    program, genome = account.weighing.program, account.weighing.genomes[blame.nearest]
    from engine.feasibility import genes_read

    genes = genes_read(program, blame.requirement)[:MOST_PARAMS]
    space = program.space
    values = [f"{space.names[g]} = {format_gene(space, g, float(genome[g]))} {space.units[g]}".rstrip() for g in genes]
    return "  " + ", ".join(values) if values else ""


def _name(account: "Account", requirement: int) -> str:
    return account.weighing.program.requirements[requirement].name


def quoted(account: "Account", requirement: int) -> str:
    return f"`{_name(account, requirement)}`"


def cure_of_conflict(account: "Account") -> str:
    """Return a cure for requirements that are proved to conflict; empty without a proof."""
    conflict, program = account.conflict, account.weighing.program
    if conflict is None or not conflict.proved:
        return ""
    ours = [r for r in conflict.requirements if program.requirements[r].line]
    if not ours:
        return "place the objects elsewhere, or widen the range of a param that their places depend on"
    if len(conflict.requirements) > 1:
        return "relax one of those that never hold together, or take it out"
    named = f"{quoted(account, ours[0])}{place_text(program, ours[0])}"
    amounts = [r.amount for r in account.relaxations if r.requirement == ours[0] and math.isfinite(r.amount)]
    if not amounts:
        return f"change {named}"
    return f"relax {named} by {amount_text(account, ours[0], amounts[0])}, or take it out"


def place_text(program: Program, requirement: int) -> str:
    line = program.requirements[requirement].line
    return f" (line {program.place(line)})" if line else ""


def blame_content(account: "Account") -> dict[str, Any]:
    """Return the account as a JSON document; margins in SI units, params in the file's own."""
    weighing, program = account.weighing, account.weighing.program
    return {
        "attempts": len(weighing),
        "acceptance": weighing.acceptance,
        "requirements": [_blame_content(account, blame) for blame in account.blames],
        "off_road": [{"object": program.actors[each.actor], "share": each.share} for each in weighing.off_road],
        "target": account.target,
        "relax": [
            {
                "name": _name(account, relaxation.requirement),
                "amount": relaxation.amount,
                "unit": program.requirements[relaxation.requirement].unit,
                "acceptance": relaxation.acceptance,
            }
            for relaxation in account.relaxations
        ],
        "conflict": account.conflict
        and {
            "requirements": [_name(account, requirement) for requirement in account.conflict.requirements],
            "proved": account.conflict.proved,
        },
    }


def _blame_content(account: "Account", blame: "Blame") -> dict[str, Any]:
    weighing, program = account.weighing, account.weighing.program
    return {
        "name": _name(account, blame.requirement),
        "line": program.requirements[blame.requirement].line or None,
        "alone": blame.alone,
        "tested": blame.tested,
        "failed": blame.failed,
        "given_earlier": blame.given_earlier,
        "acceptance_without": blame.without,
        "nearest_miss": None
        if blame.nearest < 0
        else {
            "margin": -_shortfall(account, blame),
            "unit": program.requirements[blame.requirement].unit,
            "others_failed": blame.others,
            "params": {
                name: gene_value(program.space, gene, value)
                for gene, (name, value) in enumerate(
                    zip(program.space.names, weighing.genomes[blame.nearest].tolist(), strict=True)
                )
            },
        },
    }
