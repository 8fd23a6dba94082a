"""Networks of Lanelet2 maps."""
