"""Proves sustained contact: rolling and sliding as Taylor series with proven remainders.

Imports ball arithmetic, the scene and flights. Start with phase.py.
"""
