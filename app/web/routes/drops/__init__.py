"""Routes for drops outside of rooms: single drops, many drops, pictures, proofs.

Imports routes/common.py. Start with drops.py.
"""
