"""How tasks of one event loop share work: single flight, signals, and queues that are fair.

Imports nothing of the server except its errors. Start with single_flight.py.
"""
