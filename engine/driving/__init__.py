"""Drivers from outside of a program.

`controllers`, `named` and `stacks` define drivers; `stepping` runs scenes in parallel and pauses them for actions;
`blocks` drives whole scenes; `decisions` stores the actions; `environment` offers environments for training.
"""
