"""Rooms whose balls touch each other: their scenes and inputs.

checks.py validates what clients send and makes inputs of it, table.py carries them out. Imports the
code that all rooms share. Start with room.py.
"""
