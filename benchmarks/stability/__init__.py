"""Scenes made to break a solver; what must never happen is counted.

Imports scenes, the harness and the engine. Start with stability.py.
"""
