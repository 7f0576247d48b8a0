"""Balls that touch each other, on any board or in a box.

Imports physics, boards and its own solver. Start with arena.py.
"""
