"""`cortexc repl`: a scenario written entry by entry, each checked and its acceptance estimated at once.

chunks -> entering (draft, diagnostics, acceptance), or a command of the table in `commands`; `state` is shared by both.
"""

import argparse
from pathlib import Path

from cortex_dsl.console.command import NO_COLOUR, Command, Option
from cortex_dsl.console.terminal import Terminal


def _start(options: argparse.Namespace, terminal: Terminal) -> int:
    from cortex_dsl.repl.loop import start

    return start(Path(options.file) if options.file else None, terminal)


REPL = Command(
    name="repl",
    usage="[FILE]",
    description="""\
Write a scenario entry by entry: each is checked at once, each `require` is
tested on 10,000 draws. Commands sample, draw, plot, run and search; `:help`
lists them. From a pipe (`cortexc repl < script`) entries are done one by one.""",
    options=(Option("file", "a scenario to begin with", "FILE", nargs="?"), NO_COLOUR),
    function=_start,
    epilog="""\
exit codes of a script on standard input:
  0    every entry was fine
  1    some entries or commands were refused; the rest was done
  2    a wrong command line, or FILE cannot be read
  3    the last :sample, :scene, :run, :ga or :random found no valid scene
  70   a bug in cortexc
  130  interrupted
At a terminal it is 0.
""",
    json=False,
)
