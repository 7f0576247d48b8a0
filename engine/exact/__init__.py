"""The event-driven solver: closed-form flight, the next impact to the last bits, impulse, repeat.

Imports physics and, to make its arrays, the board. Start with trace.py.
"""
