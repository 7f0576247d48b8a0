"""Several servers over one ledger: who is alive, who has which room, and how a request gets there.

The ledger (PostgreSQL) says who has a room, under a number that fences everybody else; Redis only
says who is alive. Begin with `membership`, which decides and does no I/O; `node` acts on it,
`hand_on` brings requests to the server that has their room.
"""
