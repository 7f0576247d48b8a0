"""Checks the ledger for damage: the database at each start, every room's rows on demand.

Imports the ledger, its statements and recovery/rebuild.py. Start with audit.py.
"""
