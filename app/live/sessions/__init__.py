"""Players' fair sessions: one session in memory, and all sessions in memory and in the ledger.

Imports persistence and fairness. Start with fair_sessions.py.
"""
