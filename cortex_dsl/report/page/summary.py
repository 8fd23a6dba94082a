"""A search in plain words: what was searched, how much, what was found, and what it does not show."""

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import Any

from cortex_dsl.report.findings import search_report
from cortex_dsl.report.findings.readable import counted, duration, fixed, percent, ratio
from cortex_dsl.report.findings.search_report import partners_text
from cortex_dsl.report.page.markup import Node, element, figure, prose
from engine.risk import HIGHEST_RISK
from engine.search.evaluations import Figures, distinct_collisions, figures, partners
from engine.search.journal_reader import Record
from engine.search.ranking import worst_cases
from engine.search.statistics import clopper_pearson
from engine.vocabulary import Verdict

RANDOM = "random"
"""The one method whose simulations are independent of one another, so that an interval can be given for their share."""


def method_name(method: str) -> str:
    """As people call it."""
    name = search_report.method_name(method)
    return method.replace("_", " ") if name == method else name


def whole_run(record: Record) -> tuple[Figures, Figures]:
    """By individual and by distinct simulation, over the whole run."""
    evaluations = record.evaluations
    return figures(evaluations, evaluations.reused | True), figures(evaluations, evaluations.simulated)


def headline(record: Record) -> str:
    """The result in one sentence."""
    found = distinct_collisions(record.evaluations)
    _, simulated = whole_run(record)
    tried, worst = counted(simulated.runs, "simulation"), worst_cases(record.evaluations, 1)
    if found:
        kinds = f"{counted(found, 'scene')} in which the ego collides"
        return f"{kinds}, among {tried}. The worst scores {worst[0].score} of {HIGHEST_RISK}."
    if worst and not isfinite(worst[0].min_distance):
        return f"Nothing to come near to in {tried}: nobody but the ego was in the scene."
    if worst:
        near = fixed(worst[0].min_distance, 2)
        of = tried if simulated.valid_runs == simulated.runs else f"{simulated.valid_runs:,} valid of {tried}"
        return f"No collision of the ego among {of}. The worst case comes as near as {near} m."
    return f"Not one of {tried} was valid{_why_invalid(record)}."


def paragraphs(record: Record, different: int, system: Sequence[str] = ()) -> Iterator[Node]:
    """The four questions with their answers; `different`: how many failures count as different."""
    yield _answer("What was searched", _searched(record))
    yield _answer("How much", _how_much(record))
    yield _answer("What was found", _found(record, different))
    yield _answer(
        "What this does not show",
        element("ul", [element("li", prose(text)) for text in limits(record, system)]),
        "limits",
    )


def _answer(question: str, answer: Node, name: str = "") -> Node:
    return element("div", element("h3", question), element("div", answer), class_=f"answer {name}".strip())


def _searched(record: Record) -> Node:
    manifest = record.manifest
    genes = [f"{p.name} ({_range(p)})" for p in manifest.parameters]
    others = ", ".join(manifest.actors[1:]) or "nobody else"
    return element(
        "p",
        f"The scenario {manifest.name}, in which {manifest.actors[0]} drives with {others}. "
        f"The search could choose {counted(len(genes), 'param')}: {', '.join(genes)}. "
        f"Everything else that the file leaves open was drawn at random for each scene.",
    )


def _range(parameter: Any) -> str:
    if parameter.options:
        return ", ".join(parameter.options)
    return f"{parameter.low:g} to {parameter.high:g} {parameter.unit}".strip()


def _how_much(record: Record) -> Node:
    manifest, search = record.manifest, record.manifest.settings["search"]
    everyone, simulated = whole_run(record)
    preset, name = f" (preset {manifest.preset})" if manifest.preset else "", method_name(manifest.method)
    planned = search["generations"]
    cut = "" if len(record.generations) == planned else f" of {planned:,} planned"
    took = f" It took {duration(record.seconds)}." if record.seconds == record.seconds else ""
    return element(
        "p",
        f"{name[:1].upper()}{name[1:]}{preset}, seed {manifest.seed}: ",
        f"{counted(len(record.generations), 'generation')}{cut} of {search['population']:,}, ",
        figure("by_individual.individuals", everyone.individuals, counted(everyone.individuals, "individual")),
        ". ",
        figure("by_simulation.runs", simulated.runs, counted(simulated.runs, "simulation")),
        " were distinct",
        "; the others repeat the best of the generation before." if record.evaluations.reused.any() else ".",
        took,
    )


def _found(record: Record, different: int) -> Node:
    _, simulated = whole_run(record)
    distinct = distinct_collisions(record.evaluations)
    first = first_collision(record)
    share = percent(ratio(simulated.colliding_runs, simulated.valid_runs))
    return element(
        "p",
        figure("distinct_collisions", distinct, counted(distinct, "different set")),
        " of params led to a collision of the ego",
        [", ", figure("distinct_failures", different, counted(different, "of them", "of them")), " clearly different"]
        if distinct
        else None,
        ": ",
        figure("by_simulation.colliding_runs", simulated.colliding_runs, f"{simulated.colliding_runs:,}"),
        " of ",
        figure("by_simulation.valid_runs", simulated.valid_runs, counted(simulated.valid_runs, "valid simulation")),
        f", {share}. " if simulated.valid_runs else ". ",
        _partners(record),
        f"The first came with simulation {first:,}. " if first else "",
        figure("by_simulation.nis", simulated.nis, counted(simulated.nis, "individual")),
        f" ({percent(ratio(simulated.nis, simulated.individuals))})",
        f" {'was' if simulated.nis == 1 else 'were'} invalid{_why_invalid(record)}. ",
        _worst(record),
    )


def _partners(record: Record) -> str:
    """With whom the ego collided, and with whom never."""
    actors = record.manifest.actors
    text = partners_text(actors, partners(record.evaluations, len(actors)))
    return f"By partner: {text.removeprefix('with ')}. " if text else ""


INVALID = {
    Verdict.INFEASIBLE: "no scene with its params can meet the file's requirements",
    Verdict.EXHAUSTED: "no scene met the requirements of the file, in as many attempts as are allowed",
    Verdict.ABORTED: "a requirement on the run broke, and what came after that was not simulated",
}
"""Why a simulation counts as invalid."""


def _why_invalid(record: Record) -> str:
    """`: 12 times …`, most frequent first; empty where all were valid."""
    verdicts = record.evaluations.rollouts.verdict[record.evaluations.simulated]
    counts = {why: int((verdicts == verdict).sum()) for verdict, why in INVALID.items()}
    seen = sorted((why for why in counts if counts[why]), key=lambda why: -counts[why])
    reasons = "; ".join(f"{counted(counts[why], 'time')} {why}" for why in seen)
    return f": {reasons}" if reasons else ""


def _worst(record: Record) -> str:
    scores = record.evaluations.score[record.evaluations.simulated & record.evaluations.valid]
    if not len(scores):
        return ""
    equal = int((scores == scores.max()).sum())
    return f"The highest risk found, {scores.max()} of {HIGHEST_RISK}, came up {counted(equal, 'time')}."


def first_collision(record: Record) -> int:
    """Number of the first distinct simulation, from 1, in which the ego collided; 0 for none."""
    collided = record.evaluations.collided[record.evaluations.simulated]
    return int(collided.argmax()) + 1 if collided.any() else 0


def limits(record: Record, system: Sequence[str] = ()) -> Iterator[str]:
    """What nobody should read out of these numbers."""
    _, simulated = whole_run(record)
    if record.manifest.method == RANDOM and simulated.valid_runs:
        low, high = clopper_pearson(simulated.colliding_runs, simulated.valid_runs)
        yield (
            f"How likely a collision is on a road. Among valid scenes with params spread evenly over their ranges, "
            f"{percent(low)} to {percent(high)} collide (95 % interval of Clopper and Pearson); traffic does not "
            f"spread its params evenly."
        )
    else:
        yield (
            "How likely a collision is. This search goes where it has found danger, so the share of collisions says "
            "how well it looked, not how dangerous the scenario is."
        )
    yield "That what was not found does not exist. A finite search leaves most of the space of params unseen."
    yield "That one method is better than another: this is one run with one seed. A study of many runs can show that."
    if system:
        yield (
            f"That the ego as built would fail: the search also chose {', '.join(system)}, which belong to the system "
            f"under test. `--freeze` holds them fixed."
        )
    yield (
        "How a real car behaves. Vehicles follow a kinematic model on a flat road and see without error; a finding is "
        "a scene to look at again with the real system."
    )
    yield (
        "What happens after contact. Scoring ends at first contact; the motion that is drawn lighter afterwards is "
        "rigid-body physics, for illustration."
    )
