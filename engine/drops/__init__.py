"""What users ask for: one drop, many drops, their states, digests, certainty and occupancy.

Imports the solvers and boards. Start with drop.py.
"""
