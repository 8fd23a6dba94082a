"""Are our exports right in the eyes of others? `make validate`, or `python -m benchmarks.validation`."""
