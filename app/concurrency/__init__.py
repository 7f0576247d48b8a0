"""How tasks of one event loop share work: single flight, signals, fair queues, and work that
outlives its caller.

Imports nothing of the server except its errors. Start with single_flight.py.
"""
