"""Several servers over one ledger: who is alive, who has which room, and how a request gets there.

PostgreSQL says who has a room, under a number that fences everybody else, and who is alive. Begin
with `membership`, which decides and does no I/O; `alive` says who is there, `take_over` brings
rooms here, `start` gives them away, `hand_on` brings requests to the server that has their room.
"""
