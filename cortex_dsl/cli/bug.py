"""What the user sees of a bug of ours: one line, and a file to send."""

import platform
import sys
import tempfile
import traceback
from collections.abc import Sequence
from datetime import datetime

from cortex_dsl.cli.terminal import Terminal
from cortex_dsl.version import VERSION


def report_bug(error: Exception, arguments: Sequence[str], terminal: Terminal) -> None:
    """Write the details to a file and say where it is; without a file, say them shortly."""
    summary = f"{type(error).__name__}: {error}".splitlines()[0][:200]
    details = _details(error, arguments)
    try:
        with tempfile.NamedTemporaryFile("w", prefix="cortexc-bug-", suffix=".txt", delete=False) as file:
            file.write(details)
        cure = f"please report it with the details in {file.name}"
    except OSError:
        where = traceback.extract_tb(error.__traceback__)[-1]
        cure = f"please report it: version {VERSION}, {where.name} in line {where.lineno} of {where.filename}"
    terminal.complain(f"a bug in cortexc, not in your file: {summary}", cure)


def _details(error: Exception, arguments: Sequence[str]) -> str:
    head = (
        f"cortexc {VERSION}",
        f"time: {datetime.now().astimezone().isoformat(timespec='seconds')}",
        f"command: cortexc {' '.join(arguments)}",
        f"Python {sys.version} on {platform.platform()}",
    )
    return "\n".join((*head, "", *traceback.format_exception(error)))
