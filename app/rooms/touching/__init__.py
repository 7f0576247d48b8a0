"""Rooms whose balls touch each other: their scenes, inputs, checks and log.

Imports what all rooms share. Start with room.py.
"""
