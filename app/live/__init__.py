"""Rooms as they run: the ticker, who watches, what they are told, and the registry of all rooms.

Imports persistence and rooms. Start with registry.py.
"""
