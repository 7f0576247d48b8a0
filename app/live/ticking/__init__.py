"""Ticks of awake rooms: when ticks are due, which room runs next and for how long.

Imports broadcast/. Start with runner.py, which ticker.py calls 60 times a second.
"""
