"""Several servers over one ledger: which are alive, which has each room, and forwarding to it.

PostgreSQL stores both: the servers' heartbeats, and each room's lease with its fencing number.
Begin with `membership`, which decides and does no I/O. `alive` sends and reads heartbeats,
`fail_over` fetches rooms of failed servers, `start` hands rooms over, and `forward` forwards
requests to the server that has their room.
"""
