"""Drivers from outside of a program.

Who is asked is in `controllers`, `named` and `stacks`; scenes side by side that pause for the answers in `stepping`;
whole scenes driven so in `blocks`, and what is kept of them in `decisions`; environments to train in in `environment`.
"""
