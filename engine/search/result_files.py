"""Files next to the journal, for pandas and for people: all evaluations, the critical ones, the generations, a summary.

| file              | holds                                                                                 |
|-------------------|---------------------------------------------------------------------------------------|
| evaluations.csv   | one row for each rollout of each individual; an elite's are repeated, `reused` is 1    |
| evaluations.jsonl | the same rows, one JSON object a line, with the counts per requirement as lists        |
| critical.csv      | the rows of evaluations.csv with a risk of at least 14 (a collision, under `paper`)    |
| generations.csv   | the figures of each generation, by individual and by simulation                        |
| summary.json      | manifest, figures of the whole run and of its last ten generations, worst cases, genes |
| README.md         | description of these files, and of every column with its unit                        |

Tables are the first four. A search of more than 20,000 simulations has them on request only: they are most of
the bytes of a run. They are made in parts, so that the memory for them does not grow with the search.

Numbers are written so that reading them back gives the same bits. A gene is `param_NAME`, in the file's unit; an index
gene is the number of its option. Missing numbers are empty in CSV and null in JSON.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from typing import Any

import numpy as np

from engine.assessment import take, to_columns
from engine.atomic import Content
from engine.outcomes import RESULTS, Assessment, Result
from engine.search.campaign import Campaign
from engine.search.evaluations import Evaluations, Figures, flat_rollouts, partners
from engine.search.insight.kinds import PACES, Failures, FoundKind, estimated_share
from engine.search.manifest import Manifest
from engine.search.protocol import Operator
from engine.search.ranking import Case
from engine.streams import format_key
from engine.strict_json import json_lines, json_text, plain
from engine.tables import Bools, Ints

# -- the page in every run directory: what its files are, and what their columns mean, with units ----------------------

GUIDE = "README.md"

_HEAD = """\
# Results of a search by cortexc

| file | holds |
|---|---|
| `worst/01.scn` … | the worst cases, each a scenario: `cortexc worst/01.scn`, with the `--ego` of the run |
| `failures/01.scn` … | the first scenes over which the driver failed, for `--ego`; `controller.log` says how it did |
| `summary.json` | settings and versions, figures of the whole search, worst cases, what each gene did |
| `evaluations.csv` | one row for each rollout of each individual; an elite's rows are repeated, `reused` is 1 |
| `evaluations.jsonl` | the same, one JSON object a line; `tested` and `failed` count the attempts of each requirement |
| `critical.csv` | the rows of `evaluations.csv` with a score of 14 or more |
| `generations.csv` | the figures of each generation |
| `journal.sqlite` | everything, exactly; the other files are made from it |

A search of more than 20,000 simulations writes no `.csv` and no `.jsonl` unless `--tables` asks for them;
`cortexc report RUN --tables` makes them from the journal at any time.

`summary.json` and every case contain the digest of the journal that they were made from. `cortexc verify` compares all
files with the journal, and `cortexc report` or `cortexc resume` writes them again.

## Columns of `evaluations.csv`

An empty cell is a number that does not exist. Times count from the start of the run.

| column | meaning |
|---|---|
| `individual` | number of the individual, from 0 |
| `generation`, `place` | where it stands |
| `rollout` | number of the scene drawn for this individual, from 0 |
| `operator` | how it came to be: `random`, `elite`, `crossover`, `mutation`, `crossover_mutation` |
| `reused` | 1: an elite that was not simulated again |
| `birth` | the individual that was simulated first; its own number unless reused |
| `parent_1`, `parent_2` | individuals that it was made from |
| `key` | names the random numbers of this simulation |
| `param_…` | the params, in the units of the file (see `summary.json`); of a choice, the number of its option |
| `fitness` | score of the individual over its rollouts, -1 if invalid |
"""
_TAIL = """\

## Columns of `generations.csv`

First by individual, elites included; then, as `simulated_…`, over distinct simulations only.

| column | meaning |
|---|---|
| `generation` | from 0 |
| `individuals`, `valid` | how many, and how many of them with a valid scene |
| `rl`, `rl_all` | RL, mean fitness of those that have one; and with all others as -1 |
| `nc` | NC, individuals with a collision |
| `mdg`, `mdec` | MDG, mean MD of the valid ones [m]; MDEC, of those without a collision [m] |
| `nis` | NIS, invalid individuals |
| `errors` | individuals that the engine failed on; they are not counted |
| `runs`, `valid_runs`, `colliding_runs`, `invalid_runs`, `error_runs` | the same by rollout |
"""


def guide() -> str:
    """Return the page; the descriptions of result columns are those of `RESULTS`."""
    lines: list[tuple[list[str], str]] = []
    for row in (each for whole in RESULTS if not whole.part_of for each in (whole, *_parts_of(whole))):
        if row.sentence:
            lines.append(([], row.sentence))
        lines[-1][0].extend(row.columns)
    rows = "".join(f"| {', '.join(f'`{name}`' for name in names)} | {text} |\n" for names, text in lines)
    return f"{_HEAD}{rows}{_TAIL}"


def _parts_of(whole: Result) -> Iterator[Result]:
    return (row for row in RESULTS if row.part_of == whole.name)


# -- files -------------------------------------------------------------------------------------------------------------

TABLES = ("evaluations.csv", "evaluations.jsonl", "critical.csv", "generations.csv")
"""Names of the text tables."""
ROWS = 10_000
"""Simulations in a part of a table."""
CRITICAL_RISK = 14
"""The least score of a collision under the paper's bands."""
LAST = 10
"""Generations at the end that a summary shows apart."""

_OPERATORS = {int(operator): operator.name.lower() for operator in Operator}

_CODED = tuple(row for row in RESULTS if row.words is not None)

Column = Sequence[Any]
"""One value per row: a number, a word, or None."""


def result_files(
    campaign: Campaign, manifest: Manifest, link: str = "", critical: int = CRITICAL_RISK
) -> dict[str, Content]:
    """Return all files of the table above by name; `link` is the last of their journal's chain."""
    rows = _Rows(campaign, manifest)
    return {
        "evaluations.csv": Parts(rows.lines),
        "critical.csv": Parts(partial(rows.lines, critical)),
        "evaluations.jsonl": Parts(rows.objects),
        "generations.csv": _lines(_generation_lines(campaign)),
        "summary.json": _lines([json_text({"journal": link or None, **summary(campaign, manifest)}, indent=2)]),
        GUIDE: guide().encode(),
    }


@dataclass(frozen=True)
class Parts:
    """A content that is made in parts, again for each reader."""

    make: Callable[[], Iterator[bytes]]

    def __iter__(self) -> Iterator[bytes]:
        return self.make()


def summary(campaign: Campaign, manifest: Manifest) -> dict[str, Any]:
    """Return the main results of a campaign; numbers that do not exist are NaN."""
    head = plain(manifest.stored())
    del head["file_text"]
    del head["origin"]["imports"]
    return {
        "manifest": head,
        "stopped": campaign.stopped,
        "status": campaign.status,
        "generations": len(campaign.generations),
        "seconds": campaign.elapsed,
        **failures_content(campaign.failures, campaign.kinds, manifest.actors, campaign.elapsed),
        "distinct_collisions": campaign.distinct_collisions,
        **({"broken": broken_by(campaign.evaluations, manifest.objectives)} if manifest.objectives else {}),
        **collisions_by_partner(campaign.evaluations, manifest.actors),
        "by_individual": asdict(campaign.by_individual),
        "by_simulation": asdict(campaign.by_simulation),
        "last_generations": {
            "count": LAST,
            "by_individual": asdict(campaign.last(LAST)),
            "by_simulation": asdict(campaign.last(LAST, by_simulation=True)),
        },
        "worst": [_case(campaign, case) for case in campaign.worst],
        "genes": [{**asdict(gene), "worst": list(gene.worst), "dead": gene.dead} for gene in campaign.genes],
    }


def failures_content(
    came: Failures, found: Sequence[FoundKind], actors: Sequence[str], seconds: float
) -> dict[str, Any]:
    """Return counts and rates of the ego's collisions, and every kind of collision; null for those that depend on blame
    if no collision was assessed. `avoidable_share` is the estimated share.
    """
    counts: dict[str, Any] = {**asdict(came), "avoidable_share": estimated_share(came.avoidable, came.valid)}
    if not came.judged:
        counts |= dict.fromkeys(
            (
                "avoidable",
                "disputed",
                "unavoidable",
                "no_model",
                "struck",
                "kinds",
                "avoidable_kinds",
                "avoidable_share",
            )
        )
    pace = {
        name: counts[name] / seconds if seconds > 0.0 and counts[name] is not None else None
        for name in ("avoidable", "collisions")
    }
    return {
        "failures": {**counts, "per_second": pace},
        "kinds": None
        if not came.judged
        else [
            {
                "partner": actors[each.kind.pair + 1],
                "side": each.kind.side.name.lower(),
                "heading": each.kind.heading,
                "ego_speed": PACES[each.kind.ego_speed],
                "other_speed": PACES[each.kind.other_speed],
                "blame": each.kind.blame.name.lower(),
                "count": each.count,
                "individual": each.row,
            }
            for each in found
        ],
    }


def broken_by(evaluations: Evaluations, objectives: Sequence[str]) -> dict[str, int]:
    """Return the number of distinct simulations that break each expectation."""
    broken = evaluations.rollouts.broken[evaluations.simulated]
    counts: list[float] = np.nansum(broken, axis=(0, 1)).tolist()
    is_number = np.isnan(broken).sum(axis=(0, 1)) < broken.shape[0] * broken.shape[1]
    reported: list[bool] = is_number.tolist()
    return {name: int(count) for name, count, says in zip(objectives, counts, reported, strict=True) if says}


def collisions_by_partner(evaluations: Evaluations, actors: Sequence[str]) -> dict[str, Any]:
    """Return the numbers of distinct simulations by the actor that the ego touched, and those with two others."""
    found = partners(evaluations, len(actors))
    return {
        "collisions_with": dict(zip(actors[1:], found.with_ego, strict=True)),
        "collisions_without_ego": found.without_ego,
    }


def _case(campaign: Campaign, case: Case) -> dict[str, Any]:
    genome = dict(zip(campaign.space.names, case.genome, strict=True))
    return {**asdict(case), "genome": genome, "key": format_key(case.key)}


@dataclass(frozen=True)
class _Rows:
    """The rows of the tables of simulations, one per rollout."""

    campaign: Campaign
    manifest: Manifest

    def lines(self, least: int | None = None) -> Iterator[bytes]:
        """Yield parts of the table as CSV; `least`: lowest risk of its rows."""
        for part, runs in self._parts():
            lines = list(map(",".join, zip(*map(_texts, part.values()), strict=True)))
            if least is not None:
                lines = [lines[row] for row in np.flatnonzero(runs.score >= least).tolist()]
            header = [",".join(map(_quoted, part))] if part["individual"][0] == 0 else []
            if header or lines:
                yield _lines([*header, *lines])

    def objects(self) -> Iterator[bytes]:
        """Yield parts of the table as JSON lines, with the counts of each requirement."""
        for part, runs in self._parts():
            yield _lines(json_lines(part | {"tested": runs.tested.tolist(), "failed": runs.failed.tolist()}))

    def _parts(self) -> Iterator[tuple[dict[str, Column], Assessment]]:
        """Yield the columns of some individuals after the other, with their simulations."""
        evaluations = self.campaign.evaluations
        size = max(1, ROWS // int(evaluations.keys.shape[1]))
        number, said = _numbering(evaluations), np.asarray((~np.isnan(evaluations.rollouts.broken)).any(axis=(0, 1)))
        for first in range(0, len(evaluations), size):
            part = take(evaluations, slice(first, first + size))
            runs = flat_rollouts(part)
            yield self._columns(part, runs, first, number) | _sought(runs, self.manifest, said), runs

    def _columns(
        self, evaluations: Evaluations, flat: Assessment, first: int, number: Callable[[Ints], list[int | None]]
    ) -> dict[str, Column]:
        """Return the columns of individuals, numbered from `first`."""
        rollouts = int(evaluations.keys.shape[1])
        rows = np.repeat(np.arange(len(evaluations)), rollouts)
        individuals = take(evaluations, rows) if rollouts > 1 else evaluations
        runs = to_columns(flat)
        return {
            "individual": (first + rows).tolist(),
            "generation": individuals.places[:, 0].tolist(),
            "place": individuals.places[:, 1].tolist(),
            "rollout": np.tile(np.arange(rollouts), len(evaluations)).tolist(),
            "operator": _words(individuals.operator.tolist(), _OPERATORS),
            "reused": individuals.reused.astype(int).tolist(),
            "birth": number(individuals.births),
            "parent_1": number(individuals.parents[:, 0]),
            "parent_2": number(individuals.parents[:, 1]),
            "key": _keys(evaluations),
            **{
                f"param_{name}": individuals.genomes[:, gene].tolist()
                for gene, name in enumerate(self.campaign.space.names)
            },
            "fitness": individuals.fitness.tolist(),
            **runs,
            **{row.name: _words(runs[row.name], row.words or {}) for row in _CODED},
        }


def _sought(runs: Assessment, manifest: Manifest, said: Bools) -> dict[str, Column]:
    """Return the values of objectives, and the broken expectations that any simulation of the search `said`."""
    aims = zip(manifest.objective, runs.sought.T.tolist(), strict=False)
    expected = zip(manifest.objectives, runs.broken.T.tolist(), said.tolist(), strict=False)
    found = {f"sought_{name}": values for name, values in aims}
    return found | {f"broken_{name}": values for name, values, known in expected if known}


def _numbering(evaluations: Evaluations) -> Callable[[Ints], list[int | None]]:
    """Return a function of births (n, 2) that returns numbers of individuals, None for none."""
    starts = np.flatnonzero(evaluations.places[:, 1] == 0)

    def number(births: Ints) -> list[int | None]:
        rows: list[int] = (starts[births[:, 0]] + births[:, 1]).tolist()
        return [None if missing else row for missing, row in zip(births[:, 0] < 0, rows, strict=True)]

    return number


def _keys(evaluations: Evaluations) -> Column:
    """Return stream keys as text; only birth and rollout differ within a run."""
    keys = evaluations.keys.reshape(-1, evaluations.keys.shape[2])
    seed_method_run = format_key(keys[0]).rsplit(".", 3)[0]
    return [f"{seed_method_run}.{a}.{b}.{c}" for a, b, c in keys[:, 3:].tolist()]


def _words(codes: Sequence[Any], names: Mapping[int, str]) -> Column:
    return [names[code] for code in codes]


def _texts(values: Column) -> Sequence[str]:
    """Return the cells of a column: shortest texts that read back to the same numbers; NaN and None are empty."""
    texts = [value if isinstance(value, str) else repr(value) for value in values]
    return ["" if text in ("nan", "None") else text for text in texts]


def csv_table(columns: Mapping[str, Column]) -> bytes:
    """Return columns as CSV with a header."""
    rows = map(",".join, zip(*map(_texts, columns.values()), strict=True))
    return _lines([",".join(map(_quoted, columns)), *rows])


def _generation_lines(campaign: Campaign) -> Iterable[str]:
    names = list(Figures.__dataclass_fields__)
    yield ",".join(["generation", *names, *(f"simulated_{name}" for name in names)])
    for row in campaign.generations:
        numbers = [*vars(row.by_individual).values(), *vars(row.by_simulation).values()]
        yield ",".join([str(row.generation), *("" if value != value else repr(value) for value in numbers)])


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\n') else text


def _lines(lines: Iterable[str]) -> bytes:
    return ("\n".join(lines) + "\n").encode()
