"""Sends events and snapshots to a room's clients: encoded once, and a slow client delays no other.

Imports the protocol. Start with audience.py; hub.py has the clients, transport.py their sockets.
"""
