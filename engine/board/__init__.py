"""What a board is: its parts, values, JSON form and digest, and the presets.

Imports the engine's errors and constants, and nothing about moving balls. Start with fields.py,
which lists what a board consists of, then model.py, which checks it.
"""
