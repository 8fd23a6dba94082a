"""The engine of cortexc: compiled scenarios, scenes, outcomes and searches. It is independent of scenario text."""
