"""Whether the ledger is whole and true: the database at each start, every room's rows on demand.

Imports the ledger, its statements and rebuild.py of the recovery. Start with audit.py.
"""
