"""esmini in a separate process: a script, not imported by cortexc, that plays one file and writes the states.

`python child.py RESULT`, with the job as JSON on stdin. Limits of memory and processor time are set before the library
is loaded, so that a defective esmini cannot affect its parent. Only documented calls of esminiLib.hpp are used.
"""

from __future__ import annotations

import ctypes
import json
import os
import sys
from contextlib import suppress
from ctypes import c_bool, c_char_p, c_double, c_int, c_uint32
from pathlib import Path
from typing import Any, ClassVar


class ObjectState(ctypes.Structure):
    """`SE_ScenarioObjectState` of esmini 3.6.0, with space for fields of later versions."""

    _fields_: ClassVar = [
        *((name, c_int) for name in ("id", "model_id", "ctrl_type")),
        *((name, c_double) for name in ("timestamp", "x", "y", "z", "h", "p", "r")),
        *((name, c_uint32) for name in ("road", "junction")),
        ("t", c_double),
        ("lane", c_int),
        *((name, c_double) for name in ("lane_offset", "s", "speed", "ahead", "aside", "above")),
        *((name, c_double) for name in ("width", "length", "height")),
        *((name, c_int) for name in ("kind", "category")),
        ("later", c_double * 64),
    ]


def limit(memory: int, seconds: int) -> None:
    """Limit memory [bytes] and processor time [s] of this process; otherwise only the parent's timeout applies."""
    with suppress(ImportError):
        import resource

        for what, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_CPU, seconds), (resource.RLIMIT_CORE, 0)):
            with suppress(ValueError, OSError):
                resource.setrlimit(what, (most, most + (what == resource.RLIMIT_CPU)))


def opened(path: str) -> Any:
    """Return the library, with the types of the functions that are called."""
    library = ctypes.CDLL(path)
    library.SE_Init.argtypes = [c_char_p, c_int, c_int, c_int, c_int]
    library.SE_StepDT.argtypes = [c_double]
    library.SE_GetSimulationTime.restype = c_double
    library.SE_SetOptionValue.argtypes = [c_char_p, c_char_p]
    library.SE_CollisionDetection.argtypes = [c_bool]
    library.SE_LogToConsole.argtypes = [c_bool]
    library.SE_SetLogFilePath.argtypes = [c_char_p]
    library.SE_GetIdByName.argtypes = [c_char_p]
    library.SE_GetObjectName.restype = c_char_p
    return library


def started(library: Any, job: dict[str, Any]) -> bool:
    """Return True if the library opens the file of a job."""
    library.SE_LogToConsole(False)
    library.SE_SetLogFilePath(b"esmini.log")
    library.SE_SetOptionValue(b"traj_filter", job.get("filter", "0").encode())
    library.SE_CollisionDetection(True)
    return library.SE_Init(os.fsencode(job["file"]), 0, 0, 0, 0) == 0


def record(library: Any, job: dict[str, Any]) -> dict[str, Any]:
    """Step evenly until the scenario stops, and record the actors.

    Per actor: time, name, centre of the outline, heading, height, speed, length, width, type and category. Ghosts,
    which esmini uses to look ahead, are omitted.
    """
    if not started(library, job):
        return {"refused": True}
    rows: list[list[Any]] = []
    count, ended = 0, False
    while not ended and count * job["step"] <= job["until"]:
        for index in range(library.SE_GetNumberOfObjects()):
            number = library.SE_GetId(index)
            name, state = os.fsdecode(library.SE_GetObjectName(number) or b""), _state(library, number)
            if state is not None and not name.endswith("_ghost"):
                body = [state.speed, state.length, state.width, state.kind, state.category]
                rows.append([count * job["step"], name, *_middle(state), state.z, *body])
        library.SE_StepDT(job["step"])
        count += 1
        ended = library.SE_GetQuitFlag() != 0
    library.SE_Close()
    return {"rows": rows}


def play(library: Any, job: dict[str, Any]) -> dict[str, Any]:
    """Step from instant to instant, and record the poses of outlines' centres, and collisions."""
    if not started(library, job):
        return {"refused": True}
    names = job["names"]
    poses: list[list[list[float] | None]] = []
    sizes: dict[str, list[float]] = {}
    collisions: dict[tuple[str, str], float] = {}
    now = 0.0
    for instant in job["instants"]:
        if instant > now:
            library.SE_StepDT(instant - now)
            now = instant
        ids = {name: library.SE_GetIdByName(name.encode()) for name in names}
        states = {name: _state(library, ids[name]) for name in names}
        poses.append([None if state is None else _middle(state) for state in states.values()])
        sizes.update({name: [state.length, state.width] for name, state in states.items() if state is not None})
        for pair in _collisions(library, ids):
            collisions.setdefault(pair, now)
    library.SE_Close()
    return {"poses": poses, "sizes": sizes, "collisions": [[time, *pair] for pair, time in collisions.items()]}


def _state(library: Any, number: int) -> ObjectState | None:
    state = ObjectState()
    return state if number >= 0 and library.SE_GetObjectState(number, ctypes.byref(state)) == 0 else None


def _middle(state: ObjectState) -> list[float]:
    from math import cos, sin

    x = state.x + state.ahead * cos(state.h) - state.aside * sin(state.h)
    return [x, state.y + state.ahead * sin(state.h) + state.aside * cos(state.h), state.h]


def _collisions(library: Any, ids: dict[str, int]) -> list[tuple[str, str]]:
    known = {number: name for name, number in ids.items() if number >= 0}
    found: list[tuple[str, str]] = []
    for number, name in known.items():
        for index in range(max(library.SE_GetObjectNumberOfCollisions(number), 0)):
            other = known.get(library.SE_GetObjectCollision(number, index))
            if other is not None:
                found.append((name, other))
    return found


def main() -> None:
    """Write the answer to the job on stdin into the named file."""
    job = json.load(sys.stdin)
    limit(job["memory"], job["seconds"])
    try:
        answer = (play if "instants" in job else record)(opened(job["library"]), job)
    except OSError as error:
        answer = {"missing": str(error)}
    except AttributeError as error:
        answer = {"foreign": str(error)}
    except MemoryError:
        answer = {"memory": True}
    Path(sys.argv[1]).write_text(json.dumps(answer), encoding="utf-8")


if __name__ == "__main__":
    main()
