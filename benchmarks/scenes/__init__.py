"""The boards and scenes that benchmarks and tests share.

Imports the engine. Start with boards.py.
"""
