"""Provably fair drops: commitments, signed receipts in a Merkle log, and their checker.

Pure: randomness, time and keys are arguments. May import the engine, and rooms for their canonical
JSON, which is what gets signed. Start with seeds.py, then check.py.
"""
