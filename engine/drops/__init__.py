"""Drops: one or many, with their states, digests, certainty and occupancy.

Imports the solvers and boards. Start with drop.py.
"""
