"""Checks that a board as a whole is playable: nothing overlaps, and nothing traps a ball.

Imports the parts of a board. Start with playable.py, which has the order of the checks.
"""
