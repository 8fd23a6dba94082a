"""Files that are no Lanelet2 maps, and maps without the package: a diagnostic, whether the package is there or not."""

import subprocess
import sys
from pathlib import Path

import pytest

from engine.errors import InterchangeError
from engine.lanelet2.read import read_lanelets
from tests.engine.road.lanelet_maps import ORIGIN, crossing


@pytest.mark.parametrize(
    ("osm", "said"),
    [
        ("<osm/>", "no lanelet"),
        (
            '<osm><node id="1" lat="1" lon="2"/><way id="2"><nd ref="1"/><tag k="highway" v="primary"/></way></osm>',
            "netconvert",
        ),
        ("<OpenDRIVE/>", "OpenDRIVE"),
        ("<osm", ""),
        ('<!DOCTYPE a [<!ENTITY b "c">]><osm/>', ""),
    ],
)
def test_other_files_are_named(tmp_path: Path, osm: str, said: str) -> None:
    """A file without lanelets, of another kind, or broken, is refused with a cure."""
    path = tmp_path / "map.osm"
    path.write_text(osm)
    with pytest.raises(InterchangeError) as refused:
        read_lanelets(path, ORIGIN)
    assert said in f"{refused.value.message} {refused.value.cure}"
    assert refused.value.cure


def test_without_the_package_a_command_is_offered(tmp_path: Path) -> None:
    """A scenario names the extra that is missing, and the file alone tells whether it holds lanelets."""
    (tmp_path / "map.osm").write_text(crossing().osm)
    (tmp_path / "scene.scn").write_text('map lanelet2("map.osm")\nego = new Car on road\n')
    code = (
        "import sys; sys.modules['lanelet2'] = None; sys.modules['lanelet2.io'] = None;"
        "import importlib.metadata as m; real = m.version\n"
        "def version(name):\n    if name == 'lanelet2': raise m.PackageNotFoundError(name)\n    return real(name)\n"
        "m.version = version\n"
        "from cortex_dsl.__main__ import process; sys.argv = ['cortexc', 'scene.scn', '--check']; sys.exit(process())"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    said = " ".join((done.stdout + done.stderr).split())
    assert "SCN439" in said
    assert "[lanelet2]" in said
