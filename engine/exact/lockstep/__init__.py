"""Many drops side by side on a board without drag and friction: the same bits, in less time.

Imports the exact solver. Start with trace.py.
"""
