"""How fast the engine is, and what each feature costs.

Imports the contestants, scenes, serving, harness and the engine. Start with lanes.py.
"""
