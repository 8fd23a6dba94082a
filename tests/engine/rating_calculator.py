"""Points of colourings by Euro NCAP's own calculator: a script of its interpreter, which reads and writes JSON.

Input: a list of colourings, each a mapping from cells (`CCRs/40/25`) to colours. Output: for each of them the points of
every scenario, as [standard, extended]. Sheets, matrices, ranges and scores are those of the calculator.
"""

import json
import sys

import openpyxl
import pandas as pd
from euroncap_rating_2026.crash_avoidance import data_model, matrix_processing, test_info
from euroncap_rating_2026.crash_avoidance.data_model import StageSubelementKey

SHEETS = ("FC - Car & PTW pred.", "FC - Ped & Cyc pred.")


def label(value):
    """Return a label of a matrix as cells have it: 0.25 -> `25`, `40 km/h` -> `40`, `Farside` -> `far`."""
    if isinstance(value, (int, float)):
        return str(round(value * 100))
    return str(value).removesuffix(" km/h").removesuffix("side").lower()


def sheet_with(workbook, sheet, colouring):
    """Return a prediction sheet, as the calculator reads it, with the colours of the cells that it has."""
    frame = pd.DataFrame(workbook[sheet].values, dtype=object).fillna(float("nan"))
    seen = set()
    for name, matrix in data_model.MATRIX_INDICES.items():
        found = frame.index[frame[0] == name]
        if not len(found):
            continue
        heads = frame.loc[found[0] + 1]
        row = found[0] + 2
        while row in frame.index and isinstance(frame.loc[row, 0], str):
            if name.startswith(("CPLA", "CBLA")) and pd.isna(frame.loc[row, 2]):
                frame.loc[row, 2] = "AEB"
            first = [label(frame.loc[row, 0])]
            if frame.loc[found[0], 1] == "Turn":
                first.insert(0, label(frame.loc[row, 1]))
            for column in range(matrix["start_col"], matrix["start_col"] + matrix["n_cols"]):
                cell = "/".join([name, *first, label(heads[column])])
                if cell in colouring:
                    frame.loc[row, column] = colouring[cell].capitalize()
                    seen.add(cell)
            row += 1
    return frame, seen


def points(workbook, colouring):
    """Return the points of every scenario of a colouring."""
    scores, seen = {}, set()
    for sheet in SHEETS:
        frame, found = sheet_with(workbook, sheet, colouring)
        seen |= found
        for name in data_model.MATRIX_INDICES:
            if (frame[0] == name).any():
                scores[name] = score(frame, name)
    unknown = colouring.keys() - seen
    if unknown:
        raise SystemExit(f"the workbook has no cells {sorted(unknown)[:5]}")
    return scores


def score(frame, name):
    """Return the points of a scenario; its rows that are declared as AEB and are there twice count once."""
    tests = tests_of(frame, name)
    if name.startswith(("CPLA", "CBLA")):
        frame, *_ = test_info.collapse_cpla_cbla_aeb_duplicate_rows(frame, tests, name)
        tests = tests_of(frame, name)
    return test_info.compute_predicted_score(name, tests)


def tests_of(frame, name):
    """Return the cells of a scenario."""
    indices = matrix_processing.get_matrix_indices(frame, name)
    return matrix_processing.get_test_matrix_from_region(
        frame, test_name=name, stage_subelement_key=StageSubelementKey.FC, **indices
    )


if __name__ == "__main__":
    path, colourings = sys.argv[1], json.load(sys.stdin)
    book = openpyxl.load_workbook(path, data_only=True)
    json.dump([points(book, each) for each in colourings], sys.stdout)
