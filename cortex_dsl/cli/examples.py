"""`cortexc examples` lists, prints or copies the scenarios of cortexc; `cortexc new FILE` begins one.

Neither overwrites an existing file.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from shlex import join
from textwrap import wrap

from cortex_dsl.console.command import Command, Option
from cortex_dsl.console.terminal import Exit, Terminal, UsageError
from cortex_dsl.console.user_files import reason, write_bytes
from cortex_dsl.plain_text import as_argument
from cortex_dsl.shipped import SUFFIX, Example, examples
from cortex_dsl.spelling import nearest

TEMPLATE = '''\
"""The ego crosses an intersection; another car crosses its way."""

map intersection(ways=4, lanes=1, approach=50 m)

# What a search may choose, with its range. `-p "EGO_SPEED=50 km/h"` holds one fixed.
param EGO_SPEED   = Range(20, 60) km/h
param EGO_START   = Range(15, 45) m
param OTHER_SPEED = Range(20, 60) km/h
param OTHER_START = Range(15, 45) m

# Where they go. `Uniform` leaves a choice to each scene.
egoWay    = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, intersection.maneuvers))
otherWay  = Uniform(*filter(lambda m: m.type is ManeuverType.STRAIGHT, egoWay.conflictingManeuvers))
egoPath   = [egoWay.startLane, egoWay.connectingLane, egoWay.endLane]
otherPath = [otherWay.startLane, otherWay.connectingLane, otherWay.endLane]

behavior Careful(speed, path):
    """Follow the path; brake for whatever is near and in view."""
    try:
        do FollowTrajectoryBehavior(speed, path)
    interrupt when withinDistanceToAnyObjs(self, 10 m):
        take SetBrakeAction(0.5)

ego = new Car before intersection by EGO_START along egoPath,
    with speed EGO_SPEED,
    with behavior Careful(EGO_SPEED, egoPath)
other = new Car before intersection by OTHER_START along otherPath,
    with speed OTHER_SPEED,
    with behavior FollowTrajectoryBehavior(OTHER_SPEED, otherPath)

# What each scene must fulfil, and when a run is over.
require abs(EGO_START - OTHER_START) < 20 m as "they start about as far away"
terminate after 15 s
'''
"""Contents of a file of `cortexc new`."""


def _show(options: argparse.Namespace, terminal: Terminal) -> Exit:
    if options.copy is not None:
        _copy([_found(options.example)] if options.example else examples(), options.copy, terminal)
    elif options.example:
        terminal.write(_found(options.example).text.rstrip("\n"))
    else:
        _list(options.json, terminal)
    return Exit.FINE


def _found(name: str) -> Example:
    """The example of a name, with or without its suffix.

    Raises:
        UsageError: there is no such example.
    """
    known = {example.name: example for example in examples()}
    wanted = Path(name).name.removesuffix(SUFFIX)
    if wanted in known:
        return known[wanted]
    match = nearest(wanted, known)
    cure = f"did you mean `{match}`?" if match else "`cortexc examples` lists them"
    raise UsageError(f"there is no example `{name}`", cure)


def _list(as_json: bool, terminal: Terminal) -> None:
    if as_json:
        rows = [
            {"name": each.name, "summary": each.summary, "files": [file.name for file in each.files]}
            for each in examples()
        ]
        terminal.document("examples", {"examples": rows})
        return
    width = max(len(each.name) for each in examples())
    for each in examples():
        first, *others = wrap(each.summary, max(20, terminal.out.width - width - 2))
        terminal.out.print(f"{each.name:<{width}}  ", style="title", end="")
        terminal.out.print(f"\n{'':<{width + 2}}".join((first, *others)))
    terminal.out.print("\n`cortexc examples NAME` prints one, `--copy FOLDER` writes them.", style="quiet")


def _copy(chosen: Sequence[Example], folder: Path, terminal: Terminal) -> None:
    """Write examples, and the files that they need, into a folder, all or none."""
    files = {folder / file.name: file for example in chosen for file in example.files}
    for target in files:
        _insist_on_new(target)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UsageError(f"cannot write `{folder}`: {reason(error)}", "name another folder") from None
    for target, file in files.items():
        write_bytes(target, file.read_bytes())
        terminal.out.print(str(target), soft_wrap=True)


def _insist_on_new(path: Path) -> None:
    """A file that is there stays as it is.

    Raises:
        UsageError: it is there.
    """
    if path.exists() or path.is_symlink():
        raise UsageError(f"`{path}` is there already", "name another one; cortexc writes over no scenario")


# -- a new file -------------------------------------------------------------------------------------------------------


def _new(options: argparse.Namespace, terminal: Terminal) -> Exit:
    path = options.file if options.file.suffix == SUFFIX else options.file.with_name(options.file.name + SUFFIX)
    _insist_on_new(path)
    write_bytes(path, TEMPLATE.encode())
    command = join(("cortexc", as_argument(path)))
    terminal.out.print(f"{path}: written; `{command}` runs it, `{command} --ga` searches it", soft_wrap=True)
    return Exit.FINE


# -- the commands -----------------------------------------------------------------------------------------------------


def _file(text: str) -> Path:
    path = Path(text)
    if not path.name:
        raise argparse.ArgumentTypeError(f"`{text}` names no file")
    return path


EXAMPLES = Command(
    name="examples",
    usage="[NAME] [--copy FOLDER] [--json]",
    description="The scenarios that come with cortexc: a line for each, or the text of one.",
    options=(
        Option("example", "the example to print, such as left_turn", "NAME", nargs="?"),
        Option("--copy", "write all of them, or this one, into a folder", "FOLDER", Path),
    ),
    function=_show,
    epilog="""\
examples:
  cortexc examples --copy examples     all of them, into a folder
  cortexc examples left_turn > my.scn  one, as a start of your own""",
)
NEW = Command(
    name="new",
    usage="FILE",
    description="Write a small scenario to begin with. An existing file is never overwritten.",
    options=(
        Option(
            "file",
            "its name; it gets the suffix .scn",
            "FILE",
            _file,
            nargs="?",
            missing=("no file given", "try `cortexc new first.scn`"),
        ),
    ),
    function=_new,
    json=False,
)
