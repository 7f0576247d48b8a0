"""What tasks of one event loop need of each other: do something once for all, wake all who wait,
go on when the caller has gone.

Imports nothing of the server but its errors. Start with single_flight.py.
"""
