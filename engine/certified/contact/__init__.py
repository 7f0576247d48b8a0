"""Proves sustained contact: rolling and sliding as Taylor series with proven remainders.

Imports the scene, ball arithmetic and what flights touch. Start with phase.py.
"""
