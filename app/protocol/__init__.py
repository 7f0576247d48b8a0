"""The wire protocol of a room: the messages between server and clients.

Pure: no I/O, no clock. Imports errors and the engine. Start with messages.py.
"""
