"""What is computed of a board and seeds, rooms or not: drops, pictures, many at once, proofs.

Imports common.py beside it. Start with drops.py.
"""
