"""Compute every number of an auditor's sheet again, from the tables beside it: `python tests/audit_again.py FOLDER`.

It imports nothing of this project, so that a mistake in the project's formulas shows. Each number of the page is looked
up by its name; it must be the number of the tables, and be shown with its digits.
"""

import csv
import json
import math
import re
import sqlite3
import sys
from collections import Counter
from hashlib import sha256
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

from scipy.optimize import brentq
from scipy.special import betaln, xlog1py, xlogy
from scipy.stats import beta, binom, norm

Row = dict[str, str]
Numbers = dict[str, float]
STRENGTH = 50.0
"""Strength of the mixture of the confidence sequence."""


class Page(HTMLParser):
    """The numbers of a page: name, exact value, text."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.found: list[tuple[str, float, str]] = []
        self._open: tuple[str, float] | None = None

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        known = dict(attrs)
        if tag == "data":
            self._open = str(known["data-figure"]), float(str(known["value"]))

    def handle_data(self, data: str) -> None:
        if self._open is not None:
            self.found.append((*self._open, data))
            self._open = None


# -- statistics --------------------------------------------------------------------------------------------------------


def upper(failures: int, draws: int, lost: int = 0, level: float = 0.95) -> float:
    """Return the rate at which so few failures, or fewer, have a probability of 1 - level."""
    k, n = failures + lost, draws + lost
    return 1.0 if k >= n else float(beta.ppf(level, k + 1, n - k))


def sequence(count: int, draws: int) -> tuple[float, float]:
    """Return the rates at which the mixture does not exceed the likelihood by a factor of 20."""

    def capital(p: float) -> float:
        a, b = STRENGTH * p, STRENGTH * (1.0 - p)
        mixture = float(betaln(a + count, b + draws - count) - betaln(a, b))
        return mixture - float(xlogy(count, p) + xlog1py(draws - count, -p)) - math.log(20.0)

    least, most = 1e-300, 1.0 - 1e-15
    share = min(max(count / draws, least), most)

    def end(outside: float, limit: float) -> float:
        """Return where the mixture exceeds; the limit of a rate where it never does."""
        if outside == share or capital(outside) < 0.0:
            return limit
        low, high = sorted((outside, share))
        return float(brentq(capital, low, high, xtol=1e-16, rtol=1e-15))

    return end(least, 0.0), end(most, 1.0)


def tango(b: int, c: int, n: int) -> tuple[float, float]:
    """Return the differences whose score is at most the normal quantile."""
    z, estimate = float(norm.ppf(0.975)), (b - c) / n

    def score(d: float) -> float:
        first = 2.0 * n
        second = -b - c + (2.0 * n - b + c) * d
        third = -c * d * (1.0 - d)
        q = (math.sqrt(max(0.0, second * second - 4.0 * first * third)) - second) / (2.0 * first)
        variance = n * (2.0 * q + d * (1.0 - d))
        distance = b - c - n * d
        return distance / math.sqrt(variance) if variance > 0.0 else math.copysign(1e9, distance) if distance else 0.0

    ends = ((-1.0 + 1e-12, estimate, z), (estimate, 1.0 - 1e-12, -z))
    low, high = (
        brentq(lambda d, at=at: score(d) - at, first, last, xtol=1e-15) if (score(first) - at) * (score(last) - at) < 0
        else (-1.0 if at > 0 else 1.0)
        for first, last, at in ends
    )  # fmt: skip
    return float(low), float(high)


def holm(p: list[float]) -> list[float]:
    order, worst, found = sorted(range(len(p)), key=p.__getitem__), 0.0, [0.0] * len(p)
    for rank, number in enumerate(order):
        worst = max(worst, min(1.0, (len(p) - rank) * p[number]))
        found[number] = worst
    return found


# -- numbers of each kind ----------------------------------------------------------------------------------------------


def table(path: Path) -> list[Row]:
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def of_events(events: list[tuple[str, int, int, int]], shown: list[dict[str, Any]]) -> Numbers:
    """Return the numbers of events (name, count, draws, lost), in the order of the document."""
    known = {name: rest for name, *rest in events}
    assert sorted(known) == sorted(each["name"] for each in shown), "the events of the page are not those of the table"
    found = Numbers()
    for number, each in enumerate(shown):
        count, draws, lost = known[each["name"]]
        low, high = sequence(count, draws + lost)[0], sequence(count + lost, draws + lost)[1]
        place = f"probability.events.{number}"
        found |= {f"{place}.count": count, f"{place}.draws": draws, f"{place}.low": low, f"{place}.high": high}
    return found


def of_cells(cells: dict[str, tuple[int, int, int]], shown: list[dict[str, Any]]) -> Numbers:
    """Return the numbers of cells (draws, failures, lost), in the order of the document."""
    found = Numbers()
    for number, each in enumerate(shown):
        draws, failures, lost = cells.get(each["name"], (0, 0, 0))
        place = f"failures.cells.{number}"
        found |= {f"{place}.draws": draws, f"{place}.failures": failures}
        found[f"{place}.high"] = upper(failures, draws, lost) if draws else 1.0
    assert set(cells) <= {each["name"] for each in shown}, "a cell of the table is not on the page"
    return found


def of_exposure(cells: list[tuple[int, int, int, float]]) -> Numbers:
    """Return the weighted rate of cells (draws, failures, lost, weight)."""
    cells = [each for each in cells if each[3] > 0.0]
    total = sum(each[3] for each in cells)
    level = 1.0 - 0.05 / len(cells)
    high = sum(w / total * (upper(k, n, lost, level) if n + lost else 1.0) for n, k, lost, w in cells)
    empty = sum(w / total for n, _, _, w in cells if not n)
    found = {"exposure.high": min(1.0, high), "exposure.weight_without_draws": empty}
    if not empty:
        draws = [w / total / n for n, _, _, w in cells for _ in range(n)]  # the weight of each draw
        found["exposure.rate"] = sum(w / total * k / n for n, k, _, w in cells)
        found["exposure.effective_sample_size"] = sum(draws) ** 2 / sum(each * each for each in draws)
    return found


def of_search(folder: Path, numbers: dict[str, Any]) -> Numbers:
    evaluations = table(folder / "evaluations.csv")
    found = of_draws(folder, numbers, evaluations) if numbers["failures"]["available"] else Numbers()
    return found | of_cases(folder, evaluations)


def of_draws(folder: Path, numbers: dict[str, Any], evaluations: list[Row]) -> Numbers:
    draws = table(folder / "audit-draws.csv")
    by_number = {row["individual"]: row for row in evaluations if row["rollout"] == "0"}
    valid = [row for row in draws if row["valid"] == "1"]
    for row in draws:
        stored = by_number[row["individual"]]
        assert (stored["operator"], stored["reused"]) == ("random", "0")
        assert (row["valid"] == "1") == (stored["verdict"] == "valid")
        assert row["valid"] == "0" or (row["collision"] == "1") == (stored["collided"] == "1")
    every = [
        row for row in evaluations if row["operator"] == "random" and row["reused"] == "0" and row["rollout"] == "0"
    ]
    assert len(draws) == len(every), "a draw of the search is missing"
    lost = sum(row["lost"] == "1" for row in draws)
    names = [name.removeprefix("cell of ") for name in draws[0] if name.startswith("cell of ")]
    cells: dict[str, tuple[int, int, int]] = {}
    for name in names:
        for row in valid:
            check_cell(row[f"cell of {name}"], row[f"value of {name}"])
        for text in {row[f"cell of {name}"] for row in valid} - {"", "outside"}:
            inside = [row for row in valid if row[f"cell of {name}"] == text]
            cells[f"{name} {text}"] = len(inside), sum(row["failed"] == "1" for row in inside), lost
    cells = cells or {"all": (len(valid), sum(row["failed"] == "1" for row in valid), lost)}
    broken = [name for name in draws[0] if name.startswith("broken ")]
    for row in valid:
        assert not broken or (row["failed"] == "1") == any(row[name] == "1" for name in broken)
    events = [("collision", sum(row["collision"] == "1" for row in valid), len(valid), lost)]
    events += [(n.removeprefix("broken "), sum(row[n] == "1" for row in valid), len(valid), lost) for n in broken]
    found = of_cells(cells, numbers["failures"]["cells"]) | of_events(events, numbers["probability"]["events"])
    found |= of_mechanisms([row["mechanism"] for row in valid], lost)
    if numbers["exposure"]["available"]:
        weights = table(folder / Path(numbers["exposure"]["file"]).name)
        found |= of_exposure([(*exposed(valid, row), lost, float(row["weight"])) for row in weights])
    return found


def of_cases(folder: Path, evaluations: list[Row]) -> Numbers:
    found = Numbers()
    said = Counter(row["verdict"] for row in table(folder / "audit-collisions.csv"))
    found |= {f"verdicts.{name}": said[name] for name in ("avoidable", "disputed", "unavoidable", "no_model", "struck")}
    found |= {"verdicts.judged": said.total(), "verdicts.unknown": said["unknown"]}
    cases = table(folder / "audit-cases.csv")
    adapted = [row["adapted_speed"] for row in cases if row["adapted_speed"]]
    found |= {"verdicts.adapted_speed.avoided": adapted.count("1"), "verdicts.adapted_speed.cases": len(adapted)}
    answers = [row["dynamic"] for row in cases if row["dynamic"]]
    if (folder / "verification.json").exists():
        kept = json.loads((folder / "verification.json").read_text(encoding="utf-8"))
        assert Counter(answers) == Counter(case["answer"] for case in kept["cases"][: len(cases)])
    judged = [each for each in answers if not each.startswith("not judged")]
    survive = judged.count("survives")
    found |= {"dynamic.survive": survive, "dynamic.judged": len(judged)}
    found |= {"dynamic.share": survive / len(judged)} if judged else {}
    with sqlite3.connect(folder / "journal.sqlite") as journal:
        seconds = journal.execute("SELECT seconds FROM status").fetchone()[0]
    settings = json.loads((folder / "summary.json").read_text(encoding="utf-8"))["manifest"]["settings"]
    found["effort.cpu_seconds"] = seconds * settings["search"]["jobs"]
    found["effort.simulations"] = sum(row["reused"] == "0" for row in evaluations)
    return found


def exposed(valid: list[Row], weights: Row) -> tuple[int, int]:
    """Return draws and failures of the cell of a line of an exposure."""
    names = [name for name in weights if name != "weight"]
    inside = [row for row in valid if all(row[f"cell of {name}"] == weights[name] for name in names)]
    return len(inside), sum(row["failed"] == "1" for row in inside)


def of_mechanisms(labels: list[str], lost: int) -> Numbers:
    counts = Counter(filter(None, labels))
    once, half = sum(count == 1 for count in counts.values()), len(labels) // 2
    known = set(labels[:half])
    new = sum(bool(each) and each not in known for each in labels[half:])
    return {
        "unseen.once": once,
        "unseen.kinds": len(counts),
        "unseen.draws": len(labels),
        "unseen.estimate": once / len(labels),
        "unseen.bound": upper(new, len(labels) - half, lost),
    }


def check_cell(text: str, value: str) -> None:
    """Check that a value lies in the cell whose text gives its ends."""
    if ends := re.match(r"(-?[\d.]+) to (-?[\d.]+)", text):
        assert float(ends[1]) - 1e-9 <= float(value) <= float(ends[2]) + 1e-9, f"{value} is not in {text}"


def of_suite(folder: Path, numbers: dict[str, Any]) -> Numbers:
    rows = table(folder / "cells.csv")
    drawn = [row for row in rows if int(row["runs"])]
    found = Numbers()
    if numbers["failures"]["available"]:
        cells = {row["cell"]: (int(row["runs"]), int(row["failures"]), 0) for row in drawn}
        events = [(row["cell"], int(row["failures"]), int(row["runs"]), 0) for row in drawn]
        found |= of_cells(cells, numbers["failures"]["cells"]) | of_events(events, numbers["probability"]["events"])
    if numbers["exposure"]["available"]:
        weights = {row["cell"]: float(row["weight"]) for row in table(folder / Path(numbers["exposure"]["file"]).name)}
        found |= of_exposure(
            [(int(row["runs"]), int(row["failures"]), 0, weights.get(row["cell"], 0.0)) for row in rows]
        )
    document = json.loads((folder / "suite.json").read_text(encoding="utf-8"))
    judged = [cell for group in document["groups"] for cell in group["cells"] if cell["answers"]]
    said = Counter(map(verdict, judged))
    failed = Counter(verdict(cell) for cell in judged if cell["outcome"] == "fail")
    found |= {f"verdicts.{name}": said[name] for name in ("avoidable", "disputed", "unavoidable", "no_model", "struck")}
    found |= {"verdicts.judged": said.total(), "verdicts.failed.judged": failed.total()}
    found["verdicts.failed.avoidable"] = failed["avoidable"]
    passing = [row for row in drawn if row["outcome"] == "pass"]
    sizes = {row["cell"]: float(row["deviation"]) for row in passing if row["deviation"]}
    found |= {"deviation.passing": len(passing), "deviation.turned": len(sizes)}
    listed = numbers["deviation"].get("cells", [])
    assert sorted(sizes) == sorted(each["name"] for each in listed)
    found |= {f"deviation.cells.{number}.size": sizes[each["name"]] for number, each in enumerate(listed)}
    found["effort.simulations"] = sum(group["runs"] for group in document["groups"])
    return found | of_effort(folder)


def verdict(cell: dict[str, Any]) -> str:
    """Return the verdict of the reference drivers on a cell."""
    said = {answer for counts in cell["answers"].values() for answer in counts}
    if {"avoids", "collides"} <= said:
        return "disputed"
    if said == {"struck"}:
        return "struck"
    return "avoidable" if "avoids" in said else "unavoidable" if "collides" in said else "no_model"


def of_effort(folder: Path) -> Numbers:
    effort = json.loads((folder / "effort.json").read_text(encoding="utf-8"))
    return {"effort.cpu_seconds": effort["cpu_seconds"]}


def of_comparison(folder: Path, numbers: dict[str, Any]) -> Numbers:
    document = json.loads((folder / "compare.json").read_text(encoding="utf-8"))
    paths = [Path(file["path"]).name for file in document["files"]]
    tables = sorted(folder.glob("pairs*.csv"), key=lambda path: [int(each) for each in re.findall(r"\d+", path.name)])
    found: Numbers = {"effort.simulations": 0}
    cells: dict[str, tuple[int, int, int]] = {}
    events: list[tuple[str, int, int, int]] = []
    tests: list[tuple[str, str, int, int, int]] = []
    contacts: Counter[str] = Counter()
    for name, path in zip(paths, tables, strict=True):
        rows = table(path)
        found["effort.simulations"] += 2 * len(rows)
        valid = [row for row in rows if row["verdict_a"] == row["verdict_b"] == "valid"]
        lost = sum(row["verdict_a"] == "valid" and row["verdict_b"] == "controller" for row in rows)
        cells[name] = len(valid), sum(row["change"] in ("new", "moved", "kept") for row in valid), lost
        columns = [column[:-2] for column in rows[0] if re.fullmatch(r"(broken_.*|contact|avoidable)_a", column)]
        for column in columns:
            title = {"contact": "contact of the ego", "avoidable": "avoidable contact"}.get(column, column[7:])
            a, b = ([row[f"{column}_{side}"] == "1.0" for row in valid] for side in "ab")
            prefix = f"{name}: " if len(paths) > 1 else ""
            events += [
                (f"{prefix}{title}, A", sum(a), len(valid), lost),
                (f"{prefix}{title}, B", sum(b), len(valid), lost),
            ]
            only_b = sum(two and not one for one, two in zip(a, b, strict=True))
            only_a = sum(one and not two for one, two in zip(a, b, strict=True))
            tests.append((name, title, only_b, only_a, len(valid)))
            if column in ("contact", "avoidable"):
                contacts[f"{column}_a"] += sum(a)
                contacts[f"{column}_b"] += sum(b)
    found |= of_cells(cells, numbers["failures"]["cells"]) | of_events(events, numbers["probability"]["events"])
    found |= {f"verdicts.{name}": count for name, count in contacts.items()}
    if numbers["exposure"]["available"]:
        weights = {row["file"]: float(row["weight"]) for row in table(folder / Path(numbers["exposure"]["file"]).name)}
        found |= of_exposure([(*cells[name], weights.get(name, 0.0)) for name in cells])
    family = [{"contact of the ego": 1, "avoidable contact": 2}.get(title, 0) for _, title, *_ in tests]
    p = [min(1.0, 2.0 * float(binom.cdf(min(b, a), b + a, 0.5))) if a + b else 1.0 for *_, b, a, _ in tests]
    corrected = [0.0] * len(p)
    for each in set(family):
        places = [number for number, own in enumerate(family) if own == each]
        for number, value in zip(places, holm([p[number] for number in places]), strict=True):
            corrected[number] = value
    shown = [(each["file"], each["name"]) for each in numbers["comparison"]["conditions"]]
    for (name, title, b, a, n), value in zip(tests, corrected, strict=True):
        place = f"comparison.conditions.{shown.index((name, title))}"
        low, high = tango(b, a, n)
        found |= {f"{place}.difference": (b - a) / n, f"{place}.low": low, f"{place}.high": high}
        found[f"{place}.p_holm"] = value
    for number, each in enumerate(numbers["comparison"]["residual"]):
        found[f"comparison.residual.{number}.high"] = 1.0 - 0.05 ** (1.0 / cells[each["file"]][0])
    return found | of_effort(folder)


def of_coverage(folder: Path, numbers: dict[str, Any]) -> Numbers:
    rows = table(folder / "cells.csv")
    domains = list(rows[0])[: list(rows[0]).index("state")]
    covered = [row for row in rows if row["state"] == "covered"]
    document = json.loads((folder / "coverage.json").read_text(encoding="utf-8"))
    lost = document["lost_by_driver"]
    counts = {
        ", ".join(f"{name} {row[name]}" for name in domains if row[name]): (
            int(row["runs"]),
            int(row["failures"]),
            lost,
        )
        for row in covered
    }
    found = of_cells(counts, numbers["failures"]["cells"])
    if numbers["exposure"]["available"]:
        weights = table(folder / Path(numbers["exposure"]["file"]).name)
        names = [name for name in weights[0] if name != "weight"]
        own = {
            tuple(row[name] for name in names): (int(row["runs"]), int(row["failures"]))
            for row in covered
            if {name for name in domains if row[name]} == set(names)
        }
        found |= of_exposure(
            [(*own.get(tuple(row[n] for n in names), (0, 0)), lost, float(row["weight"])) for row in weights]
        )
    found["effort.simulations"] = document["draws"] + document["lost"]
    return found | of_effort(folder)


def of_test(folder: Path, numbers: dict[str, Any]) -> Numbers:
    document = json.loads((folder / "test.json").read_text(encoding="utf-8"))
    files = [file for file in document["files"] if not file["kept"]]
    several = len(document["files"]) > 1
    counts = {
        f"{Path(file['path']).name}: {check['name']}" if several else check["name"]: (
            check["runs"],
            check["failures"],
            0,
        )
        for file in files
        for check in file["checks"]
    }
    found = of_cells(counts, numbers["failures"]["cells"])
    found |= of_events([(name, k, n, 0) for name, (n, k, _) in counts.items()], numbers["probability"]["events"])
    return found | {"effort.simulations": document["runs"]}


READERS = {
    "search": of_search,
    "suite": of_suite,
    "comparison": of_comparison,
    "coverage": of_coverage,
    "test": of_test,
}


def digest(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return sha256(path.read_bytes()).hexdigest()


# -- the page ----------------------------------------------------------------------------------------------------------


def shown_as(value: float, text: str) -> bool:
    """Return True if a text shows a number with its digits: a count, a share in percent, or digits of a number."""
    if parts := re.fullmatch(r"(?:(\d+) h )?(?:(\d+) min ?)?(?:([\d.]+) s)?", text):
        hours, minutes, seconds = (float(part or 0.0) for part in parts.groups())
        least = 60.0 if parts[1] else 1.0 if parts[2] or "." not in text else 0.1
        return abs(3600.0 * hours + 60.0 * minutes + seconds - value) <= 0.5 * least + 1e-9
    share = text.endswith(" %")
    plain = text.removesuffix(" %").replace(",", "")
    shown, exact = float(plain), value * (100.0 if share else 1.0)
    mantissa, _, power = plain.partition("e")
    ulp = 10.0 ** (int(power or 0) - len(mantissa.partition(".")[2]))
    return abs(shown - exact) <= 0.5 * ulp * (1.0 + 1e-9)


def differences(folder: Path, documented: tuple[float, float]) -> list[str]:
    """Return each number of the page that the tables do not give, with the reason."""
    page = Page()
    page.feed((folder / "audit.html").read_text(encoding="utf-8"))
    document = json.loads((folder / "audit.json").read_text(encoding="utf-8"))
    numbers = READERS[document["kind"]](folder, document["numbers"])
    numbers |= {"time_step.low": documented[0], "time_step.high": documented[1]}
    found: list[str] = []
    for name, value, text in page.found:
        if name not in numbers:
            found.append(f"{name}: {text} comes from no table")
        elif not math.isclose(value, numbers[name], rel_tol=1e-9, abs_tol=1e-12):
            found.append(f"{name}: {value}, and {numbers[name]} by the tables")
        elif not shown_as(numbers[name], text):
            found.append(f"{name}: {numbers[name]} is shown as {text}")
        elif not document["numbers"][name.split(".")[0]]["available"]:
            found.append(f"{name} is on the page and not available")
    for name, value in numbers.items():
        stored = stored_value(document["numbers"], name)
        if stored is not None and not math.isclose(stored, value, rel_tol=1e-9, abs_tol=1e-12):
            found.append(f"{name}: {stored} in the document, and {value} by the tables")
    if not page.found:
        found.append("the page has no number")
    return found


def stored_value(numbers: Any, name: str) -> float | None:
    """Return a number of the document by its place, as in `failures.cells.0.high`; None if it has none."""
    value = numbers
    for part in name.split("."):
        if not isinstance(value, dict | list):
            return None
        value = value[int(part)] if isinstance(value, list) else value.get(part)
    return value


if __name__ == "__main__":
    readme = Path(__file__).parents[1] / "benchmarks" / "README.md"
    row = next(line for line in readme.read_text(encoding="utf-8").splitlines() if line.startswith("| `step_bias`"))
    ends = re.findall(r"\+([\d.]+) to \+([\d.]+) %", row)[0]
    wrong = differences(Path(sys.argv[1]), (float(ends[0]) / 100.0, float(ends[1]) / 100.0))
    sys.stdout.write("\n".join(wrong) or "every number of the page is that of the tables\n")
    sys.exit(bool(wrong))
