"""The version of cortexc, where it can be read without asking the installer; a test holds it to `pyproject.toml`."""

VERSION = "0.2.0"
