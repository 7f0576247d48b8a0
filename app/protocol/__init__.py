"""The wire protocol of a room, pure: bytes in, values out, and back.

Imports the engine. Start with messages.py.
"""
