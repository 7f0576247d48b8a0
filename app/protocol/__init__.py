"""The wire protocol of a room, pure: what clients say and what they are told, as bytes.

Imports errors and the engine. Start with messages.py.
"""
