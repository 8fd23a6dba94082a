"""The table of formats: every row writes what it says."""

from dataclasses import replace
from pathlib import Path

import pytest

from cortex_dsl.cli import main
from cortex_dsl.interchange import formats
from cortex_dsl.interchange.cases import ExportCase
from cortex_dsl.interchange.formats import FORMATS, gather, missing_extra
from engine.errors import InterchangeError
from engine.extras import installing
from engine.interchange.contract import MODES, OSC_VERSIONS, Export, ExportOptions
from engine.interchange.sources import read_recording

INSTALLED = [name for name in FORMATS if not missing_extra(name)]
EVERY_FORMAT = pytest.mark.parametrize("name", INSTALLED)


@EVERY_FORMAT
def test_it_writes_the_files_of_its_row(worst: ExportCase, name: str) -> None:
    """Names begin with the case's or the road's, and end as the row says, the one to open first before the others."""
    export = FORMATS[name].writer(worst, worst.recording.name, ExportOptions())
    endings = FORMATS[name].suffixes
    assert len(export.files) == len(endings)
    for file, ending in zip(export.files, endings, strict=True):
        stem = "left_turn" if ending == ".xodr" else "left_turn-case01"
        assert file == f"{stem}{ending}"


@EVERY_FORMAT
def test_the_same_case_gives_the_same_files(worst: ExportCase, name: str) -> None:
    """Byte for byte: an export can be repeated, and compared."""
    once, again = (FORMATS[name].writer(worst, "case", ExportOptions()) for _ in range(2))
    assert once == again


@EVERY_FORMAT
@pytest.mark.parametrize("mode", MODES)
def test_nothing_that_was_written_is_found_fault_with(worst: ExportCase, name: str, mode: str, tmp_path: Path) -> None:
    """`--check` has nothing to say about our own files."""
    export = FORMATS[name].writer(worst, worst.recording.name, ExportOptions(mode=mode))
    for file, content in export.files.items():
        (tmp_path / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    assert list(FORMATS[name].load_checker()(worst, tmp_path, list(export.files), ExportOptions(mode=mode))) == []


def test_a_missing_package_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    """How to have it installed."""
    monkeypatch.setitem(formats.FORMATS, "csv", replace(FORMATS["csv"], package="no_such_package", extra="many"))
    assert missing_extra("csv") == installing("many")


NAMES = ("OpenSCENARIO", "CommonRoad", "ScenarioRunner", "Scenic", "`")


ASKED = [(name, ExportOptions()) for name in INSTALLED]
ASKED += [("xosc", ExportOptions(osc, mode)) for osc in OSC_VERSIONS for mode in MODES]


@pytest.mark.parametrize(("name", "how"), ASKED)
def test_remarks_are_of_one_style(worst: ExportCase, name: str, how: ExportOptions) -> None:
    """No full stop, and a small letter first unless it is a name: they stand in lists, behind their format."""
    for remark in FORMATS[name].writer(worst, worst.recording.name, how).remarks:
        assert not remark[0].isupper() or remark.startswith(NAMES), remark
        assert not remark.endswith("."), remark


def test_cases_share_a_road(worst: ExportCase) -> None:
    """Two cases of a scenario are written beside one road."""
    other = replace(worst, recording=replace(worst.recording, name="left_turn-case02"))
    gathered = gather([worst, other], ["xosc", "scenic"], ExportOptions())
    assert sorted(gathered.files) == [
        "left_turn-case01.scenic",
        "left_turn-case01.xosc",
        "left_turn-case02.scenic",
        "left_turn-case02.xosc",
        "left_turn.xodr",
    ]
    assert gathered.names[1] == ["left_turn-case02.xosc", "left_turn.xodr", "left_turn-case02.scenic"]


def test_a_remark_is_kept_once(worst: ExportCase) -> None:
    """With the cases that it is about."""
    gathered = gather([worst, worst], ["scenic"], ExportOptions())
    assert gathered.remarks
    assert all(numbers == [0, 1] for numbers in gathered.remarks.values())


def test_what_cannot_be_carried_names_case_and_format(worst: ExportCase, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> Export:
        raise InterchangeError("too fast", "drive slower")

    monkeypatch.setattr("engine.interchange.tables.write_csv", refused)
    with pytest.raises(InterchangeError, match="left_turn-case01 as csv: too fast") as caught:
        gather([worst], ["csv"], ExportOptions())
    assert caught.value.cure == "drive slower"


def test_a_missing_package_stops_its_own_format_only(worst: ExportCase, monkeypatch: pytest.MonkeyPatch) -> None:
    """What was asked for beside it is written."""
    monkeypatch.setitem(formats.FORMATS, "mcap", replace(FORMATS["mcap"], package="no_such_package"))
    gathered = gather([worst], ["mcap", "csv"], ExportOptions())
    assert list(gathered.refused) == ["mcap"]
    assert "no_such_package" in str(gathered.refused["mcap"])
    assert set(gathered.formats.values()) == {"csv"}


@pytest.mark.skipif("parquet" not in INSTALLED, reason="pyarrow is not installed")
def test_a_parquet_table_has_the_road(worst: ExportCase, tmp_path: Path) -> None:
    """In its metadata; what is read is the `.xodr` that is exported, and goes along with what is made of the table."""
    (road,) = FORMATS["xodr"].writer(worst, "case", ExportOptions()).files.values()
    export = FORMATS["parquet"].writer(worst, "case", ExportOptions())
    (content,) = export.files.values()
    assert not any("of the road" in remark for remark in export.remarks)
    (tmp_path / "case.parquet").write_bytes(content if isinstance(content, bytes) else b"")
    read = read_recording(tmp_path / "case.parquet")
    assert read.road is not None
    assert (read.road.path.name, read.road.copy().decode()) == ("left_turn.xodr", road)
    assert main(["measure", str(tmp_path / "case.parquet"), "--to", "xosc,scn", "--json"]) == 0
    assert (tmp_path / "left_turn.xodr").read_text() == road
    assert 'map opendrive("left_turn.xodr")' in (tmp_path / "case.scn").read_text()
