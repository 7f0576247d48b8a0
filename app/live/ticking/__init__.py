"""Rooms that are awake: when they tick, whose turn it is, and what comes of it.

Imports broadcast/. Start with runner.py, which ticker.py calls 60 times a second.
"""
