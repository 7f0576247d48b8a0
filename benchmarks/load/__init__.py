"""Many clients in one room, and what each of them gets: the load generator.

Imports the protocol. Start with generator.py.
"""
