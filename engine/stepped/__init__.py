"""The time-stepping solver of one ball: semi-implicit Euler with swept tests against tunnelling.

Imports physics, and the board arrays and the event log of the exact solver. Start with step.py.
"""
