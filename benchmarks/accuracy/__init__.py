"""Run time against error: which engine finds the true path, and how much time that takes.

Imports the contestants, scenes, harness and the engine. Start with accuracy.py.
"""
