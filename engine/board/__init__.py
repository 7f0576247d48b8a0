"""What a board is: its parts, values, JSON form and digest, and the presets.

Imports the engine's errors and constants; knows nothing of balls in motion. Start with fields.py,
what a board consists of, then model.py, how it is checked.
"""
