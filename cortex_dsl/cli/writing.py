"""Files written at once or not at all."""

import contextlib
import errno
import os
import stat
import tempfile
from pathlib import Path

from cortex_dsl.cli.exits import UsageError
from cortex_dsl.cli.files import reason


def write_bytes(path: Path, content: bytes) -> None:
    """Put a content into a file at once: whoever reads it, at whatever moment, sees all of the old or all of the new.

    Mode and owner of a file that is there stay; one that may not be written is left alone.

    Raises:
        UsageError: it cannot be written.
    """
    try:
        _replace(Path(os.path.realpath(path)), content)
    except OSError as error:
        raise UsageError(f"cannot write `{path}`: {reason(error)}") from None
    except ValueError:
        raise UsageError(f"`{path}` cannot be the name of a file") from None


def _replace(target: Path, content: bytes) -> None:
    old = target.stat() if target.exists() else None
    if old is not None and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
    number, name = tempfile.mkstemp(dir=target.parent, prefix=".cortexc-")
    try:
        with os.fdopen(number, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(number)
        Path(name).chmod(0o666 & ~_umask() if old is None else stat.S_IMODE(old.st_mode))
        if old is not None:
            with contextlib.suppress(OSError):  # only root gives files away
                os.chown(name, old.st_uid, old.st_gid)
        Path(name).replace(target)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def _umask() -> int:
    mask = os.umask(0o077)
    os.umask(mask)
    return mask
