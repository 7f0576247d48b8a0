"""Players' fair sessions while the server runs: one of them, and all of them over the ledger.

Imports persistence and fairness. Start with fair_sessions.py.
"""
