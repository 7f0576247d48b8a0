"""The event-driven solver: follows a ball from event to event by closed forms.

Imports physics and, to make its arrays, the board. Start with trace.py.
"""
