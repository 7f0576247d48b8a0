"""Loads rooms from the ledger, ends runs that cannot continue, and sets damaged rooms aside.

recovery.py finds and loads rooms: tables from their facts, touching balls by a replay (rebuild.py,
pure). ending.py ends a run as it is. Imports the ledger and its statements. Start with recovery.py.
"""
