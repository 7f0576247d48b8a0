"""Rooms as pure values: inputs go in, events and binary messages come out.

room.py has the interface and the common code; independent.py and touching/ are the two kinds of
room, and kinds.py makes one. Imports the protocol and the engine; no I/O, no clock. Start with
room.py.
"""
