"""The time-stepping solver of one ball: semi-implicit Euler, swept so that nothing tunnels.

Imports physics, and the board arrays and the event log of the exact solver. Start with step.py.
"""
