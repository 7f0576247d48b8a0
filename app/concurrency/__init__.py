"""What tasks of one event loop need of each other: do something once for all, wake all who wait.

Imports nothing of the server. Start with single_flight.py.
"""
