"""`python -m docs.builder FOLDER [--no-gallery]` builds the site into a folder."""

import argparse
import sys
from pathlib import Path

from docs.builder.site import build


def main() -> int:
    parser = argparse.ArgumentParser(prog="python -m docs.builder", description="Build the site into a folder.")
    parser.add_argument("folder", type=Path, metavar="FOLDER")
    parser.add_argument("--no-gallery", action="store_true", help="no replays, which need a search of each example")
    options = parser.parse_args()
    return build(options.folder, gallery=not options.no_gallery)


if __name__ == "__main__":
    sys.exit(main())
