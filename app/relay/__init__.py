"""Relays: processes that forward a room's events, received over a bus, to its spectators.

All spectators of the stream `seeds` receive the same few messages. So the room's server publishes
each of them once to a channel of a bus (`bus`; Redis in `redis_bus`), and any number of relays
forward them. Begin with `replica`, a relay's side of one room; `feed` is the server's side, and
`served` is the relay's application.
"""
