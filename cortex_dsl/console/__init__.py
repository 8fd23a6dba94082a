"""What the command line and the session share: the terminal, exits and slips, the user's files, compiling and running."""
