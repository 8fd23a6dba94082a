"""A driver in a process of its own: it drives as one in this process does, and what befalls it is told."""

import hashlib
import importlib.util
import os
import random
import select
import shutil
import sqlite3
import subprocess
import sys
import time
from contextlib import closing, suppress
from itertools import accumulate
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import cortex_dsl as cx
from engine.driving import stacks
from engine.driving.blocks import Driven, Driver
from engine.driving.named import named_driver
from engine.driving.stacks import Memory, stack_of
from engine.errors import ControllerError, LostError
from engine.vocabulary import Verdict
from tests.engine.driving.test_blocks import same

TABLES = ("individual", "simulation", "action")
OWN = Path(__file__).parents[3] / "examples" / "own_driver"
TEXT = """
param SPEED = Range(5, 15) m/s
ego = new Car on road, with speed SPEED, with behavior ExternalBehavior()
terminate after 0.5 s
"""
CLIENT = """
import json, os, sys, time
import numpy as np
read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb")
header = json.loads(read.readline())
n, wide = header["lanes"], len(header["observations"])
write.write(b'{"version": VERSION}\\n')
write.flush()
fast = np.zeros(n, dtype=bool)
while True:
    head = read.read(8 + 8 * n + 48 * n + 2 * n)
    seen = np.frombuffer(read.read(8 * n * wide), "<f8").reshape(-1, wide)
    if len(seen) < n:
        break
    number = int.from_bytes(head[:8], "little")
    asked = np.frombuffer(head[-n:], "u1").astype(bool)
    print("question", number, flush=True)
    HOOK
    write.write(np.tile([0.5, 0.0, 0.0], (n, 1)).astype("<f8").tobytes())
    write.flush()
"""


@pytest.fixture
def scenario() -> cx.Scenario:
    return cx.compile_text(TEXT)


def client(tmp_path: Path, hook: str = "pass", version: int | str = 1) -> str:
    """The name of a driver that does something else at each question."""
    path = tmp_path / "client.py"
    path.write_text(CLIENT.replace("HOOK", hook).replace("VERSION", str(version)))
    return f"process:{sys.executable} {path}"


def half(seen: np.ndarray) -> np.ndarray:
    return np.tile([0.5, 0.0, 0.0], (len(seen), 1))


def driven(scenario: cx.Scenario, name: str, count: int = 4) -> Driven:
    driver = named_driver(name, block=4)
    return driver.drive(scenario.program, scenario.sample(count, seed=1), scenario.config.simulation)


def test_a_process_drives_as_a_function_does(scenario: cx.Scenario, tmp_path: Path) -> None:
    """The same decisions, the same runs; what it prints disturbs nobody."""
    done = driven(scenario, client(tmp_path), 6)
    here = Driver(half).drive(scenario.program, scenario.sample(6, seed=1), scenario.config.simulation)
    same(done.outcomes, here.outcomes)
    assert np.array_equal(done.scenes.actions, here.scenes.actions)
    assert not done.remarks


def test_a_question_larger_than_a_pipe_arrives_as_it_is(tmp_path: Path) -> None:
    """It is written part by part, each of which may stop anywhere."""
    lanes, wide, rng = 5_000, 60, np.random.default_rng(2)
    digest = "import hashlib; write.write(hashlib.sha256(head + seen.tobytes()).digest() * (3 * n // 4)); continue"
    name = client(tmp_path, digest).removeprefix("process:")
    stack = stack_of(name)
    named = [{"name": str(number)} for number in range(wide)]
    stack.meet({"version": 1, "lanes": lanes, "observations": named, "actions": named[:3]})
    keys, seen, times = rng.integers(0, 9, (lanes, 6)), rng.random((lanes, wide)), rng.random(lanes)
    stack.reset(np.arange(lanes), keys)
    asked = rng.random(lanes) < 0.5
    answers = [stack.act(seen, asked, times).tobytes()[:32] for _ in range(2)]
    stack.close()
    for number, (fresh, answer) in enumerate(zip((True, False), answers, strict=True)):
        parts = (np.int64(number), times, keys, np.full(lanes, fresh), asked, seen)
        assert answer == hashlib.sha256(b"".join(part.tobytes() for part in parts)).digest()


def in_c(tmp_path: Path) -> str:
    """The name of the client in C."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no compiler of C")
    flags = ("-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off")
    subprocess.run([compiler, *flags, "-o", tmp_path / "stack", OWN / "stack.c"], check=True)
    return f"process:{tmp_path / 'stack'}"


def test_the_client_in_c_drives_by_speed_where_it_is_asked_to(tmp_path: Path) -> None:
    """It counts the actions that our first line names."""
    text = (
        (OWN / "crossing.scn")
        .read_text(encoding="utf-8")
        .replace("straight, every", 'straight, actions="speed", every')
    )
    scenario = cx.compile_text(text)
    done = named_driver(in_c(tmp_path), block=8).drive(scenario.program, scenario.sample(8, seed=2))
    assert (done.remarks, done.outcomes.verdict.tolist()) == ((), [Verdict.VALID] * 8)
    assert done.scenes.actions[0, 0].tolist() == [10.0, 0.0]


@pytest.mark.parametrize("client", ["stack.py", "stack_in_memory.py", "stack.c"])
def test_the_reference_clients_decide_as_the_planner_does(client: str, tmp_path: Path) -> None:
    """Their scenes end alike, bit for bit; some scenes make the planner brake."""
    scenario = cx.load(OWN / "crossing.scn")
    scenes, config = scenario.sample(64, seed=2), scenario.config.simulation
    name = in_c(tmp_path) if client == "stack.c" else f"process:{sys.executable} {OWN / client}"
    done = named_driver(name, block=64).drive(scenario.program, scenes, config)
    assert (done.outcomes.verdict == Verdict.VALID).all()
    here = Driver(planner().drive, block=64).drive(scenario.program, scenes, config)
    assert (here.scenes.actions[:, :, 1] == 1.0).any(axis=1).sum() > 5
    np.testing.assert_array_equal(done.scenes.actions, here.scenes.actions)
    same(done.outcomes, here.outcomes)


def planner() -> ModuleType:
    """The module beside the clients, which import it by its name."""
    spec = importlib.util.spec_from_file_location("planner", OWN / "planner.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_crash_that_does_not_recur_costs_a_remark(scenario: cx.Scenario, tmp_path: Path) -> None:
    """It is started anew, and its block is driven again."""
    mark = tmp_path / "crashed"
    hook = f"(number != 3 or os.path.exists({str(mark)!r})) or (open({str(mark)!r}, 'w').close(), os._exit(9))"
    done = driven(scenario, client(tmp_path, hook))
    here = Driver(half).drive(scenario.program, scenario.sample(4, seed=1), scenario.config.simulation)
    same(done.outcomes, here.outcomes)
    assert len(done.remarks) == 1
    assert "ended with exit code 9; it printed: question 0\nquestion 1" in done.remarks[0]


def test_the_scene_over_which_it_crashes_is_found(scenario: cx.Scenario, tmp_path: Path) -> None:
    """Blocks are halved until that scene is alone; all others are as if nothing had happened."""
    scenes = scenario.sample(4, seed=1)
    hook = "asked[2] and number > 2 and os._exit(3)"
    done = driven(scenario, client(tmp_path, hook))
    assert done.outcomes.verdict.tolist() == [0, 0, int(Verdict.CONTROLLER), 0]
    here = Driver(half).drive(scenario.program, scenes, scenario.config.simulation)
    for row in (0, 1, 3):
        assert done.outcomes.end_time[row] == here.outcomes.end_time[row]
        assert np.array_equal(done.scenes.actions[row], here.scenes.actions[row])
    assert scenario.assess(done.outcomes).score[2] == -1


def test_kills_at_random_moments_change_no_journal(scenario: cx.Scenario, tmp_path: Path) -> None:
    """Whoever is killed now and then finds what he finds undisturbed: the same evaluations, the same actions.

    Between two kills the block is driven again to its end: a scene over which it dies again and again is lost.
    """
    dice, asked = random.Random(), str(tmp_path / "asked")
    moments = list(accumulate((dice.randint(30, 50) for _ in range(10)), initial=4))
    counted = f"(open({asked!r}, 'a').write('x'), len(open({asked!r}).read()))[1]"
    hook = f"{counted} in {moments} and os.kill(os.getpid(), 9)"
    (tmp_path / "calm").mkdir()
    names = client(tmp_path / "calm"), client(tmp_path, hook)
    found = []
    for number, name in enumerate(names):
        out = tmp_path / f"run{number}"
        scenario.driven_by(name, block=4).search("ga", generations=4, population=16, seed=1, out=out)
        with closing(sqlite3.connect(out / "journal.sqlite")) as journal:
            found.append([list(journal.execute(f"SELECT * FROM {table} ORDER BY 1, 2")) for table in TABLES])
    assert (tmp_path / "run1" / "controller.log").read_text().count("was ended by signal 9") > 2
    assert found[0] == found[1], moments


def test_a_late_stack_is_killed(scenario: cx.Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With all that it has started: nothing waits, nothing is left."""
    monkeypatch.setattr(stacks, "LATE", 0.3)
    pids = tmp_path / "pids"
    hook = f"(open({str(pids)!r}, 'a').write(f'{{os.getpid()}} '), os.fork() or time.sleep(60), time.sleep(60))"
    started = time.monotonic()
    with pytest.raises(ControllerError, match="was started 3 times and never answered"):
        driven(scenario, client(tmp_path, hook))
    assert time.monotonic() - started < 30.0
    time.sleep(0.1)
    for pid in pids.read_text().split():
        with pytest.raises(ProcessLookupError):
            os.kill(int(pid), 0)


@pytest.mark.parametrize(
    ("hook", "message"),
    [
        ("write.write(bytes(48)); write.flush(); continue", "over an answer, of which 48 of 96 bytes came"),
        ("write.write(bytes(96))", "gave more than the 96 bytes of an answer"),
    ],
)
def test_an_answer_of_another_size_is_told(
    scenario: cx.Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, hook: str, message: str
) -> None:
    """As one of float32, or one of each lane twice: with the size that is expected."""
    monkeypatch.setattr(stacks, "LATE", 0.5)
    seen = np.zeros((4, 1))
    stack = stack_of(client(tmp_path, hook).removeprefix("process:"))
    stack.meet({"version": 1, "lanes": 4, "observations": [{}], "actions": [{}] * 3})
    if "more" in message:
        stack.act(seen, np.ones(4, dtype=bool))
        select.select([stack._running.read], [], [], 30.0)  # pyright: ignore[reportOptionalMemberAccess]
    with pytest.raises(LostError, match=message) as told:
        stack.act(seen, np.ones(4, dtype=bool))
    assert told.value.cure == "write 96 bytes for each question, 4 rows of 3 float64, and flush them"


def test_a_stack_that_died_is_told_though_a_child_holds_its_pipes(scenario: cx.Scenario, tmp_path: Path) -> None:
    """At once, and how it ended; one that has started another and ended well is waited for."""
    stack = stack_of(client(tmp_path, "os._exit(7) if os.fork() else time.sleep(60)").removeprefix("process:"))
    stack.meet({"version": 1, "lanes": 4, "observations": [{}], "actions": [{}] * 3})
    started = time.monotonic()
    with pytest.raises(LostError, match="ended with exit code 7") as told:
        stack.act(np.zeros((4, 1)), np.ones(4, dtype=bool))
    assert told.value.cure == "look for what ends it, or run it by itself"
    assert time.monotonic() - started < stacks.LATE / 2
    launched = driven(scenario, client(tmp_path, "number == 0 and os.fork() and os._exit(0); time.sleep(0.5)"), 1)
    assert (launched.remarks, launched.outcomes.verdict.tolist()) == ((), [Verdict.VALID])


SHARING = """
import json, mmap, os
import numpy as np
read = os.fdopen(int(os.environ["CORTEXC_READ"]), "rb")
write = os.fdopen(int(os.environ["CORTEXC_WRITE"]), "wb", buffering=0)
header = json.loads(read.readline())
n, starts = header["lanes"], header["memory"]
room = mmap.mmap(int(os.environ["CORTEXC_MEMORY"]), starts["size"])
def part(name, kind, *shape):
    return np.ndarray(shape, kind, room, starts[name])
parts = [part("number", "<i8", 1), part("times", "<f8", n), part("keys", "<i8", n, 6), part("fresh", "u1", n)]
parts += [part("asked", "u1", n), part("observations", "<f8", n, len(header["observations"]))]
done = part("actions", "<f8", n, len(header["actions"]))
write.write(b'{"version": 1, "memory": true}\\n')
while len(read.read(8)) == 8:
    HOOK
    write.write(b"!")
"""


SHARED = pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="no memory that two processes share")


def sharing(tmp_path: Path, hook: str) -> str:
    """The name of a driver that shares memory."""
    (tmp_path / "sharing.py").write_text(SHARING.replace("HOOK", hook))
    return f"process:{sys.executable} {tmp_path / 'sharing.py'}"


@SHARED
def test_a_stack_sees_in_memory_what_others_are_sent(tmp_path: Path) -> None:
    """All parts of each question, aligned, and its answer is what it left there."""
    lanes, wide, rng = 7, 5, np.random.default_rng(2)
    hook = "done[:] = sum(float(np.sum(each * (2.0 + number))) for number, each in enumerate(parts))"
    stack = stack_of(sharing(tmp_path, hook).removeprefix("process:"))
    stack.meet({"version": 1, "lanes": lanes, "observations": [{}] * wide, "actions": [{}] * 3})
    keys, times = rng.integers(0, 9, (lanes, 6)), rng.random(lanes)
    stack.reset(np.arange(lanes), keys)
    for number in range(3):
        seen, asked = rng.random((lanes, wide)), rng.random(lanes) < 0.5
        parts = np.array([number]), times, keys, np.full(lanes, number == 0), asked, seen
        answer = stack.act(seen, asked, times)
        assert answer.shape == (lanes, 3)
        assert answer == pytest.approx(sum(float(np.sum(each * (2.0 + n))) for n, each in enumerate(parts)))
    stack.close()


@SHARED
def test_a_stack_that_shares_memory_is_judged_as_all_are(
    scenario: cx.Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It dies and is started anew, answers twice, or sleeps."""
    mark = tmp_path / "crashed"
    crash = (
        f"parts[0][0] == 3 and not os.path.exists({str(mark)!r}) and (open({str(mark)!r}, 'w').close(), os._exit(9))"
    )
    done = driven(scenario, sharing(tmp_path, f"{crash}; done[:] = [0.5, 0.0, 0.0]"))
    here = Driver(half).drive(scenario.program, scenario.sample(4, seed=1), scenario.config.simulation)
    same(done.outcomes, here.outcomes)
    assert len(done.remarks) == 1
    monkeypatch.setattr(stacks, "LATE", 0.3)
    with pytest.raises(ControllerError, match="was started 3 times and never answered"):
        driven(scenario, sharing(tmp_path, "__import__('time').sleep(60)"))
    monkeypatch.undo()
    stack = stack_of(sharing(tmp_path, "write.write(b'!')").removeprefix("process:"))
    stack.meet({"version": 1, "lanes": 4, "observations": [{}], "actions": [{}] * 3})
    stack.act(np.zeros((4, 1)), np.ones(4, dtype=bool))
    select.select([stack._running.read], [], [], 30.0)  # pyright: ignore[reportOptionalMemberAccess]
    with pytest.raises(LostError, match="gave more than the 1 byte of an answer") as told:
        stack.act(np.zeros((4, 1)), np.ones(4, dtype=bool))
    assert told.value.cure == "write one byte for each question, once its actions stand in the memory"


@SHARED
def test_stacks_that_die_leave_no_file_open(scenario: cx.Scenario, tmp_path: Path) -> None:
    """Neither pipes nor memory nor logs, however often one is started."""

    def opened() -> int:
        return len(list(Path("/proc/self/fd").iterdir()))

    before = opened()
    for hook in ("os._exit(3)", "done[:] = 0.0"):
        for _ in range(3):
            stack = stack_of(sharing(tmp_path, hook).removeprefix("process:"))
            stack.meet({"version": 1, "lanes": 4, "observations": [{}], "actions": [{}] * 3})
            with suppress(LostError):
                stack.act(np.zeros((4, 1)), np.ones(4, dtype=bool))
            stack.close()
            assert opened() == before
    with pytest.raises(ControllerError):
        driven(scenario, "process:./nothing")
    assert opened() == before


def test_shared_memory_stays_as_large_as_it_is() -> None:
    """To read where it was before it shrank would end us."""
    memory = Memory(4, 3, 2)
    try:
        with pytest.raises(PermissionError):
            os.ftruncate(memory.descriptor, 0)
    finally:
        os.close(memory.descriptor)


def test_memory_that_was_not_offered_cannot_be_shared(
    scenario: cx.Scenario, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stacks.Memory, "of", staticmethod(lambda *_: None))
    (tmp_path / "client.py").write_text(CLIENT.replace("HOOK", "pass").replace("VERSION}", '1, "memory": true}'))
    with pytest.raises(ControllerError, match="would share memory, of which this system has none"):
        driven(scenario, f"process:{sys.executable} {tmp_path / 'client.py'}")
    same_as_ever = driven(scenario, client(tmp_path))
    assert same_as_ever.outcomes.verdict.tolist() == [Verdict.VALID] * 4


def test_another_version_is_told(scenario: cx.Scenario, tmp_path: Path) -> None:
    for said, told in ((7, "7"), ("true", "True"), ("1.0", "1.0")):
        with pytest.raises(ControllerError, match=f"speaks version {told} of the protocol; this is version 1"):
            driven(scenario, client(tmp_path, version=said))


def test_what_cannot_be_started_is_told(scenario: cx.Scenario) -> None:
    with pytest.raises(ControllerError, match=r"`\./nothing` cannot be started: no such file or directory"):
        driven(scenario, "process:./nothing")
    with pytest.raises(ControllerError, match="names no command"):
        named_driver("process: ")
    with pytest.raises(ControllerError, match="is not a command"):
        named_driver("process:'")


def test_nan_of_a_process_is_told(scenario: cx.Scenario, tmp_path: Path) -> None:
    """As of any other."""
    name = client(tmp_path, "write.write(np.full((n, 3), np.nan).astype('<f8').tobytes())")
    with pytest.raises(ControllerError, match="the controller `ego` gave throttle = nan, in scene 0"):
        driven(scenario, name)


def test_the_folder_of_a_driver_hides_no_module(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A driver is found in the current folder, now and when it imports a neighbour later; other modules are not."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [path for path in sys.path if path not in ("", str(tmp_path))])
    text = "def drive(seen):\n    import neighbour_of_it\n    return neighbour_of_it.ACTION\n"
    contents = {"driver_of_here": text, "neighbour_of_it": "ACTION = 1", "wave": "", "second_here": text}
    for name, content in contents.items():
        (tmp_path / f"{name}.py").write_text(content)
    for name in ("driver_of_here", "second_here"):
        named_driver(f"python:{name}:drive")
        spec = importlib.util.find_spec("wave")
        assert spec is not None
        assert not str(spec.origin).startswith(str(tmp_path))
        assert sys.modules[name].drive(None) == 1
