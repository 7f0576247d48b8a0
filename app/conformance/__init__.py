"""What a test laboratory asks of the program itself: its digests, and tests of its generator.

May import the server's settings and fair drops, and the engine. Start with inventory.py.
"""
