"""Rooms as pure values: balls go in, events and frames come out; what a room logs and keeps.

Imports the protocol and the engine; no I/O, no clock. Start with independent.py.
"""
