"""How tasks of one event loop share work: single flight and signals.

Imports nothing of the server except its errors. Start with single_flight.py.
"""
