"""The road network as a program sees it, and its traffic lights."""
