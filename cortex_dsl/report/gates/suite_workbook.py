"""The result of `cortexc suite` in the workbook of the rating calculator of Euro NCAP: a colour for each cell.

The workbook is a template of that program (`euroncap_rating_2026 crash_avoidance generate-template`), made by the user.
Its layout is that of version 5.4.9: the name of a scenario heads each matrix, its second row has the columns.
"""

import io
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cortex_dsl.report.findings.suite_report import SuiteReport
from engine.errors import ArgumentError
from engine.extras import needed
from engine.gates.ratings import Colour

VERSION = "5.4.9"
"""Version of the calculator whose templates are known."""
SHEETS = ("FC - Car & PTW pred.", "FC - Ped & Cyc pred.")
GENERATE = "generate one with `euroncap_rating_2026 crash_avoidance generate-template`"
FUNCTION, BRAKE = "Function", "AEB"
"""Head of the column in which a row is declared, and what it is declared as where the row leaves a choice."""


class WorkbookError(ArgumentError):
    """A workbook that cannot be filled."""


def template_of(path: Path) -> Any:
    """Return the workbook of a template.

    Raises:
        MissingExtraError: openpyxl is not installed.
        WorkbookError: the file is no template of the known version.
    """
    openpyxl = needed("openpyxl", "workbooks of the rating calculator need", "workbook")
    try:
        book = openpyxl.load_workbook(path)
    except FileNotFoundError:
        raise WorkbookError(f"there is no workbook {path}", GENERATE) from None
    except (OSError, KeyError, ValueError, zipfile.BadZipFile, openpyxl.utils.exceptions.InvalidFileException) as error:
        raise WorkbookError(f"{path} is no workbook: {error}", GENERATE) from None
    rows = dict(_first_two(book["Version"])) if "Version" in book.sheetnames else {}
    found = rows.get("Template version")
    if found != VERSION or any(name not in book.sheetnames for name in SHEETS):
        what = f"of version {found}" if found is not None else "no template of the rating calculator"
        raise WorkbookError(f"{path} is {what}; the colours of version {VERSION} are known", GENERATE)
    return book


def _first_two(sheet: Any) -> Iterator[tuple[Any, Any]]:
    for row in sheet.iter_rows(max_col=2, values_only=True):
        yield row[0], row[1] if len(row) > 1 else None


def filled(book: Any, report: SuiteReport) -> bytes:
    """Return the workbook with the colours of the cells.

    A cell that is not run is red, as in the points. Other choices, such as layers of robustness, stay as they are.

    Raises:
        WorkbookError: no cell of the suite is in the workbook.
    """
    colours = {cell.id: cell.colour or Colour.RED for cell in report.cells}
    count = sum(_fill(book[name], colours) for name in SHEETS)
    if count == 0:
        raise WorkbookError(f"no cell of `{report.suite}` is in the workbook", "fill that of euroncap-2026")
    content = io.BytesIO()
    book.save(content)
    return content.getvalue()


def _fill(sheet: Any, colours: Mapping[str, Colour]) -> int:
    """Fill the matrices of a sheet; return the number of its cells that have a colour now."""
    names, count, row = {each.split("/")[0] for each in colours}, 0, 1
    while row <= sheet.max_row:
        name = sheet.cell(row, 1).value
        if name not in names:
            row += 1
            continue
        heads = [cell.value for cell in sheet[row]]
        columns = {cell.column: _label(cell.value) for cell in sheet[row + 1] if cell.value is not None}
        row += 2
        while isinstance(sheet.cell(row, 1).value, str):
            count += _fill_row(sheet, row, str(name), heads, columns, colours)
            row += 1
    return count


def _fill_row(
    sheet: Any, row: int, name: str, heads: list[Any], columns: Mapping[int, str], colours: Mapping[str, Colour]
) -> int:
    first = [_label(sheet.cell(row, 1).value)]
    if len(heads) > 1 and heads[1] == "Turn":
        first.insert(0, _label(sheet.cell(row, 2).value))
    found = {column: colours.get("/".join([name, *first, label])) for column, label in columns.items()}
    found = {column: colour for column, colour in found.items() if colour is not None}
    declared = next((number for number, head in enumerate(heads, start=1) if head == FUNCTION), None)
    if found and declared is not None and sheet.cell(row, declared).value is None:
        sheet.cell(row, declared).value = BRAKE
    for column, colour in found.items():
        cell = sheet.cell(row, column)
        choices = _choices(sheet, cell.coordinate)
        # A row that is declared as AEB and is there twice has the choices of a warning; the calculator leaves it out.
        cell.value = colour.capitalize() if not choices or colour.capitalize() in choices else Colour.RED.capitalize()
    return len(found)


def _choices(sheet: Any, place: str) -> frozenset[str]:
    """Return the choices of a cell; empty if it may be anything."""
    for rule in sheet.data_validations.dataValidation:
        if rule.type == "list" and place in rule.sqref and isinstance(rule.formula1, str):
            return frozenset(rule.formula1.strip('"').split(","))
    return frozenset()


def _label(value: object) -> str:
    """Return a label of a matrix as cells of the suite have it: 0.25 -> `25`, `40 km/h` -> `40`, `Farside` -> `far`."""
    if isinstance(value, int | float):
        return str(round(value * 100))
    return str(value).removesuffix(" km/h").removesuffix("side").lower()
