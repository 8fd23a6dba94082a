"""A readable print of the checked IR, for `--emit ir`."""
