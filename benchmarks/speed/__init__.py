"""How fast the engine is, and how much time each feature takes.

Imports the contestants, scenes, serving, harness and the engine. Start with lanes.py.
"""
