"""Shared parts of the command line and the session: output, exit codes, files, compiling and running."""
