"""What the command line and the session share: where output goes, how a command ends, files, compiling and running."""
