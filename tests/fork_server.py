"""A process that imports once what many others need, and forks one of them for each piece of code.

What Python, numba and the kernels need to start is then paid once, not for each process that a test kills or asks.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

SERVING = """
import json, os, sys, traceback

def begin(code, words, folder, environment, files):
    for number, (name, flags) in enumerate([(os.devnull, os.O_RDONLY), *((file, os.O_WRONLY) for file in files)]):
        os.dup2(os.open(name, flags), number)
    os.chdir(folder)
    os.environ.update(environment)
    sys.argv[:] = ["-c", *words]
    exec(code, names)

def end(*request):
    status = 0
    try:
        begin(*request)
    except SystemExit as left:
        status = left.code if isinstance(left.code, int) else int(left.code is not None)
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(status)

names = {"__name__": "__main__"}
exec(sys.argv[1], names)
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        end(*json.loads(line))
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), file=sys.__stdout__, flush=True)
"""


@dataclass(frozen=True)
class Ended:
    """What a process left: its exit status, below 0 for the signal that killed it, and what it said."""

    status: int
    out: str
    err: str


class ForkServer:
    """A process that has run `prelude` and forks for each piece of code; to be used in a `with`."""

    def __init__(self, prelude: str, folder: Path, *flags: str, environment: dict[str, str] | None = None) -> None:
        """`folder`: an empty one, to stand in and to keep what processes say; `flags` are Python's."""
        self.said = (folder / "out", folder / "err")
        command = [sys.executable, *flags, "-c", SERVING, prelude]
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(command, cwd=folder, env=environment, stdin=pipe, stdout=pipe, text=True)

    def run(self, code: str, *words: object, at: Path | None = None, **environment: str) -> Ended:
        """Run code that knows the prelude's names, with these arguments and this beside the environment."""
        process, out, err = self.process, *self.said
        for file in self.said:
            file.write_text("", encoding="utf-8")
        request = [code, [str(word) for word in words], str(at or Path.cwd()), environment, [str(out), str(err)]]
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(json.dumps(request) + "\n")
        process.stdin.flush()
        answer = process.stdout.readline()
        assert answer, "the server has ended"
        return Ended(int(answer), out.read_text(encoding="utf-8"), err.read_text(encoding="utf-8"))

    def __enter__(self) -> "ForkServer":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.communicate()
        assert self.process.returncode == os.EX_OK
