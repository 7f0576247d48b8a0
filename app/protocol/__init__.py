"""The wire protocol of a room: the messages between server and clients, as bytes. Pure.

Imports errors and the engine. Start with messages.py.
"""
