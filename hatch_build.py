"""Kernels in a wheel: with CORTEXC_WHEEL_KERNELS=FOLDER a wheel carries the compiled kernels of that folder.

`make wheel` fills one (`wheels.compile_kernels`). Without it a wheel is pure Python, and kernels are compiled at the
first start.
"""

import os
import sys
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

KERNELS = "CORTEXC_WHEEL_KERNELS"


class KernelsHook(BuildHookInterface):
    """Adds the folder, and tags of this Python and of the platforms that llvmlite was built for."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        folder = os.environ.get(KERNELS)
        if not folder or version == "editable":
            return
        if not (Path(folder) / "target.json").is_file():
            raise FileNotFoundError(f"{KERNELS}: no compiled kernels are in `{folder}`")
        build_data["force_include"][str(Path(folder).resolve())] = "engine/kernels/compiled"
        build_data["pure_python"] = False
        platforms = platform_tags()
        python = f"cp{sys.version_info.major}{sys.version_info.minor}"
        build_data.update({"tag": f"{python}-{python}-{platforms}"} if platforms else {"infer_tag": True})


def platform_tags() -> str:
    """Return the platforms of the installed llvmlite, which loads the kernels, as a tag; empty if it is not here."""
    try:
        lines = (distribution("llvmlite").read_text("WHEEL") or "").splitlines()
    except PackageNotFoundError:
        return ""
    tags = [line.removeprefix("Tag: ").strip() for line in lines if line.startswith("Tag: ")]
    return ".".join(sorted({tag.split("-")[2] for tag in tags}))
