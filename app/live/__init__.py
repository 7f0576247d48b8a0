"""Rooms as they run: the registry of all, their ticks, who watches them and what they are sent.

registry.py finds and opens rooms, open_rooms.py says which stay in memory, inputs.py takes what is
asked of them, ticking/ ticks those awake, broadcast/ sends what comes of it, sessions/ has players'
fair sessions. Imports persistence and rooms. Start with registry.py.
"""
