"""ASAM OpenODD 1.0: read an operational design domain as domains of a file, and write coverage as `openodd` reads it.

An ODD is read by the package `openodd-py`: a binding file, whose attributes have buckets, or a document alone. Values
that break the conditions of its modules lie outside the ODD; an attribute without a value leaves the verdict unknown.
Coverage is written without the package.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise, product
from pathlib import Path
from typing import Any

from cortex_dsl.report.findings.coverage_report import CoverageReport, DomainInfo, DomainTotal, State
from cortex_dsl.semantics.names.tree import everything_in
from cortex_dsl.semantics.quantities.units import UNITS
from cortex_dsl.source import Source
from cortex_dsl.syntax import nodes, parse
from cortex_dsl.version import VERSION
from engine.errors import InterchangeError
from engine.extras import needed

SCHEMA = "openodd.coverage/1"
"""Schema of a coverage file of openodd-py 0.13.0 (`openodd.report.COVERAGE_SCHEMA`)."""
SUFFIX = "_coverage.json"
"""End of the names of such files (`openodd.report.COVERAGE_FILE_GLOB`)."""
SEPARATOR = " / "
"""Text between the labels of a cell of several items (`openodd.items.CROSS_SEPARATOR`)."""
BELOW, ABOVE = "<below>", "<above>"
"""Buckets of numbers below and above all buckets."""
OTHER = "<other>"
"""Bucket of values between buckets, or that are none of the values."""
COUNTERPARTS: Mapping[str, str] = {
    "ego_speed": "ego.speed",
    "ego_vehicle_speed": "ego.speed",
    "subject_vehicle_speed": "ego.speed",
}
"""Values of attributes (ISO 34503, dynamic elements) of which the file has no domain or param of the same name."""


@dataclass(frozen=True)
class OddDomains:
    """An ODD as domains of a file."""

    source: Source
    """The file with the domains of the ODD below it."""
    module: nodes.Module
    """Its syntax tree, without the domains of the file itself."""
    definition: Any
    """`openodd.OddDefinition`"""
    attributes: tuple[str, ...]
    """Names of the attributes, by domain."""
    remarks: tuple[str, ...]
    """Attributes that are not covered, and why."""

    def verdict(self, values: Mapping[str, Any]) -> str:
        """Return whether values by domain (None: no value) lie `inside` or `outside` the ODD, or are `unknown`."""
        found = self.definition.evaluate({name: values.get(name) for name in self.attributes})
        return "unknown" if found.assumed else "inside" if found.inside else "outside"

    def labels(self, attribute: str) -> list[str]:
        """Return the labels of the buckets of an attribute; [] for another domain."""
        found = [each for each in self.definition.attributes if each.name == attribute]
        return list(found[0].item.labels) if found and attribute in self.attributes else []

    def outside(self, attribute: str) -> tuple[str, ...]:
        """Return the labels of the buckets of an attribute that lie outside the ODD."""
        return tuple(self.definition.outside_buckets(attribute)) if attribute in self.attributes else ()


def read_odd(path: Path) -> Any:
    """Return the `openodd.OddDefinition` of a binding file or an OpenODD document.

    Raises:
        MissingExtraError: openodd-py is not installed.
        InterchangeError: the file cannot be read.
    """
    openodd = needed("openodd", "an ODD needs", "odd", "openodd-py")

    class Anything(openodd.Backend):
        """Backend that accepts every probe: values come from simulated runs."""

        def probe(self, _spec: str) -> Any:
            return _nothing, ""

        def read(self, _key: str, _value: str) -> Any:
            return _nothing, ""

        def reader_keys(self) -> list[str]:
            return ["measure"]

    try:
        return openodd.load_odd_file(path, backend=Anything())
    except (OSError, ValueError) as error:
        cure = "a binding file names probes with a `unit` and `buckets`, `values` or `range` and `every`"
        reason = f"{error}".partition("\n")[0]
        raise InterchangeError(f"cannot read `{path}` as an ODD: {reason}", cure, str(path)) from None


def _nothing(_context: Any) -> None: ...


def odd_domains(definition: Any, source: Source, module: nodes.Module, path: Path) -> OddDomains:
    """Return the attributes of an ODD as domains of a file.

    Raises:
        InterchangeError: no attribute has a counterpart in the file.
    """
    own = [each for each in module.statements if isinstance(each, nodes.Domain)]
    values = {_plain(each.name): (source.slice(each.value.span), each.when) for each in own}
    for entry in (each for each in everything_in(module) if isinstance(each, nodes.ParamEntry)):
        values.setdefault(_plain(entry.name), (entry.name, "start"))
    lines: list[str] = []
    names: list[str] = []
    remarks: list[str] = []
    for attribute in definition.attributes:
        found = _counterpart(attribute.name, values)
        cells, reason = _cells(attribute)
        if found is None or not cells:
            remarks.append(f"`{attribute.name}` of the ODD {reason if found else 'has no counterpart in the file'}")
            continue
        value, when = found
        lines.append(f'domain "{attribute.name}" ({value}) at {when} in [{", ".join(cells)}]')
        names.append(attribute.name)
    if not lines:
        known = ", ".join(sorted({*COUNTERPARTS, *(each.name for each in own)}))
        cure = f"name a `domain` or `param` of the file as an attribute; the names known here are {known}"
        raise InterchangeError(f"no attribute of `{path}` can be a domain: {'; '.join(remarks)}", cure, str(path))
    extended = replace(source, text="\n".join((source.text.rstrip(), *lines, "")))
    made = parse(extended)
    statements = [each for each in made.statements if not _is_of_file(each, source)]
    return OddDomains(extended, replace(made, statements=tuple(statements)), definition, tuple(names), tuple(remarks))


def _is_of_file(statement: nodes.Statement, source: Source) -> bool:
    """Return True for a domain that the file itself has."""
    return isinstance(statement, nodes.Domain) and statement.span.start < len(source.text)


def _plain(name: str) -> str:
    return re.sub(r"[\s_\-]+", "_", name.strip().lower())


def _counterpart(name: str, values: Mapping[str, tuple[str, str]]) -> tuple[str, str] | None:
    """Return value and instant of an attribute: by its whole name, else by its last part."""
    for word in (_plain(name), _plain(name.rpartition(".")[2])):
        if word in values:
            return values[word]
        if word in COUNTERPARTS:
            return COUNTERPARTS[word], "start"
    return None


def _cells(attribute: Any) -> tuple[list[str], str]:
    """Return the buckets of an attribute in the language, or none and the reason."""
    item = attribute.item
    if item is None:
        return [], "has no buckets: give it some in a binding file"
    if item.edges:
        unit = attribute.unit
        if unit and unit not in UNITS:
            return [], f"has the unit `{unit}`, which is unknown here"
        ends = [f"{edge!r} {unit}".rstrip() for edge in item.edges]
        return [f"({low}, {high})" for low, high in pairwise(ends)], ""
    return [_written(label) for label in item.labels], ""


def _written(label: str) -> str:
    """Return a value of the language from the label of a bucket."""
    if label in ("true", "false"):
        return label.capitalize()
    return label if re.fullmatch(r"[+-]?\d+(\.\d+)?", label) else f'"{label}"'


# -- coverage ----------------------------------------------------------------------------------------------------------


def coverage_document(report: CoverageReport, odd: OddDomains | None = None) -> dict[str, Any]:
    """Return a coverage as a coverage file of `openodd`: runs in each bucket, and in each cell of a product of domains
    at one instant.
    """
    labels = [_labels(domain, odd) for domain in report.domains]
    outside = [() if odd is None else odd.outside(domain.name) for domain in report.domains]
    runs = {(cell.domains, cell.cells): cell.runs for cell in report.cells if cell.state is State.COVERED}
    crosses: list[dict[str, Any]] = []
    for domains in dict.fromkeys(cell.domains for cell in report.cells):
        if len(domains) > 1 and len({report.domains[domain].when for domain in domains}) == 1:
            places = product(*(range(len(labels[domain])) for domain in domains))
            hits = {
                SEPARATOR.join(labels[domain][place] for domain, place in zip(domains, cells, strict=True)): runs.get(
                    (domains, cells), 0
                )
                for cells in places
            }
            crosses.append(_cross(report, domains, hits, [outside[domain] for domain in domains]))
    return {
        "schema": SCHEMA,
        "generator": {"cortexc": VERSION},
        "scenario": Path(report.path).stem,
        "items": [_item(*each, odd=odd) for each in zip(report.domains, report.totals, labels, outside, strict=True)],
        "crosses": crosses,
        "odd": None,
        "case": None,
        "outcome": None,
    }


def _labels(domain: DomainInfo, odd: OddDomains | None) -> list[str]:
    """Return the labels of the cells as `openodd` writes them."""
    if odd is not None and (known := odd.labels(domain.name)):
        return known
    if not domain.is_numeric:
        return [{"True": "true", "False": "false"}.get(cell, cell.strip("\"'")) for cell in domain.cells]
    *others, last = [(f"{low:.12g}", f"{high:.12g}") for low, high in domain.ends]
    return [*(f"[{low}, {high})" for low, high in others), f"[{last[0]}, {last[1]}]"]


def _item(
    domain: DomainInfo, total: DomainTotal, labels: Sequence[str], outside: Sequence[str], odd: OddDomains | None
) -> dict[str, Any]:
    group = "scenario" if odd is None or domain.name not in odd.attributes else "odd"
    others = {BELOW: total.below, ABOVE: total.above, OTHER: total.other}
    return {
        "name": f"odd.{domain.name}" if group == "odd" else domain.name,
        "group": group,
        "text": domain.text,
        "unit": domain.unit,
        "event": _event(domain),
        "kind": "numeric" if domain.is_numeric else "categorical",
        **_criteria(dict(zip(labels, total.runs, strict=True)), outside),
        "samples": sum(total.runs) + sum(others.values()),
        "ignored": 0,
        "out_of_range": {label: count for label, count in others.items() if count},
        **({"attribute": domain.name} if group == "odd" else {}),
    }


def _cross(
    report: CoverageReport, domains: Sequence[int], hits: Mapping[str, int], outside: Sequence[Sequence[str]]
) -> dict[str, Any]:
    named = [report.domains[domain] for domain in domains]
    left_out = [
        cell
        for cell in hits
        if any(label in never for label, never in zip(cell.split(SEPARATOR), outside, strict=False))
    ]
    return {
        "name": " x ".join(each.name for each in named),
        "group": "scenario",
        "text": "",
        "event": _event(named[0]),
        "items": [each.name for each in named],
        **_criteria(hits, left_out),
    }


def _criteria(hits: Mapping[str, int], outside: Sequence[str]) -> dict[str, Any]:
    """Return buckets and measures; a run is one hit and takes no time of its own."""
    return {
        "buckets": list(hits),
        "target": 1,
        "cover_by": "hits",
        "min_stay": None,
        "amount": "hits",
        "outside_odd": list(outside),
        "hits": dict(hits),
        "seconds": dict.fromkeys(hits, 0.0),
        "meters": dict.fromkeys(hits, 0.0),
        "entries": dict(hits),
    }


def _event(domain: DomainInfo) -> str:
    return domain.when if domain.when in ("start", "end") else f"condition:{domain.when}"
