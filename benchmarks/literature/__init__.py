"""The engine compared with published figures.

Imports the engine and the harness. Start with literature.py.
"""
