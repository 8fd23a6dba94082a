"""The engine of cortexc: compiled scenarios in, scenes, outcomes and searches out. It knows no scenario text."""
