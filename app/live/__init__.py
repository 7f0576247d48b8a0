"""Running rooms: their registry, their ticks, the clients that watch them, and fair sessions.

live_table.py is a table of independent balls, live_arena.py a room of touching balls, live_room.py
what they have in common. registry.py finds, opens and closes rooms; open_rooms.py decides which
stay in memory; stored_rooms.py has those in the ledger, arriving.py and leaving.py bring them here
and give them to other servers. ticking/ runs the ticks of awake rooms; broadcast/ sends events to
clients; sessions/ has the fair sessions. Imports persistence and rooms.
Start with live_table.py.
"""
