"""Lanelet2 maps as plain data, by the package `lanelet2`."""
