"""Evidence for a test laboratory: digests of the program, and tests of its random starts.

May import the server's settings and fair drops, and the engine. Start with inventory.py.
"""
