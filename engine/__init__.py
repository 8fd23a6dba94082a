"""The engine of cortexc: compiled scenarios in, scenes, outcomes and searches out. It has never heard of text."""
