"""Rooms whose balls touch each other: their scenes, their inputs, what is checked and carried out.

checks.py makes inputs of what clients send, table.py carries them out. Imports what all rooms
share. Start with room.py.
"""
