"""Several servers over one ledger: who is alive, who has which room, and how a request gets there.

PostgreSQL says who has a room, under a number that fences everybody else, and who is alive. Begin
with `membership`, which decides and does no I/O; `alive` and `node` act on it, `hand_over` gives
rooms to others, `hand_on` brings requests to the server that has their room.
"""
