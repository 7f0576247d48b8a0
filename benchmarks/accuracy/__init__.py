"""Run time against error: who finds the true path, and at what price.

Imports the contestants, scenes, harness and the engine. Start with accuracy.py.
"""
