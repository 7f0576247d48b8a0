"""Rooms as they run: the registry of all, their ticks, who watches them and what they are sent.

live_room.py is one room, with all that is asked of it and comes of it; registry.py finds, opens and
closes rooms, open_rooms.py says which stay in memory, ticking/ has those awake tick, broadcast/
sends what comes of it, sessions/ has players' fair sessions. Imports persistence and rooms. Start
with live_room.py.
"""
