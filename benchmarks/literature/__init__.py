"""The engine held against published numbers that nobody here computed.

Imports the engine and the harness. Start with literature.py.
"""
