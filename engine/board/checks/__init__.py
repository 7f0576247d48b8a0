"""What a board must fulfil to be played, as a whole: nothing overlaps, nothing traps a ball.

Imports the parts of a board. Start with playable.py, the order of the checks.
"""
