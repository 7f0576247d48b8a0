"""Scenes made to break a solver, in which faults such as tunnelling are counted.

Imports scenes, the harness and the engine. Start with stability.py.
"""
