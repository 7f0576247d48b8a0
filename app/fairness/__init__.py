"""Drops that nobody could choose: commitments, signed receipts in a Merkle log, and their checker.

Pure: chance, time and keys come in as arguments. May import rooms (whose canonical JSON is what is
signed) and the engine. Start with seeds.py, then check.py.
"""
