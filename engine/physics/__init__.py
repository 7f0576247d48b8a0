"""The laws of motion as kernels: flight, impact, contact, and the times at which they change.

Imports only `plinko.engine.jit` and constants. Start with flight.py, then time_of_impact.py.
"""
