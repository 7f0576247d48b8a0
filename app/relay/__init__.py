"""Processes that pass on what happens in a room to those who watch it: relays, over a bus.

By seeds every spectator is sent the same few messages, so the room's own process sends them once,
to a channel of a bus (`bus`, Redis in `redis_bus`), and any number of relays send them on. Begin
with `replica`, a relay's side of one room; the room's side is `feed`, `served` what a relay serves.
"""
