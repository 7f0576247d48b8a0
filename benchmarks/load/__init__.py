"""The load generator: many clients in one room, and statistics of what they receive.

Imports the protocol. Start with generator.py.
"""
