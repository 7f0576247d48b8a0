"""The laws of motion as kernels: flight, impact, contact, and the instants at which they change.

Imports `engine.jit` and constants alone. Start with flight.py, then time_of_impact.py.
"""
