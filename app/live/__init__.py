"""Running rooms: their registry, their ticks, the clients that watch them, and fair sessions.

live_room.py is one room with its requests, ticks and events; registry.py finds, opens and closes
rooms; open_rooms.py decides which stay in memory; ticking/ runs the ticks of awake rooms;
broadcast/ sends events to clients; sessions/ has the fair sessions. Imports persistence and rooms.
Start with live_room.py.
"""
