"""The ledger's tables, and what is asked of them over a connection that somebody else opened.

tables has them, for SQLAlchemy Core; store reads and prunes, writing takes in what is handed in, in
its order; fair_store (players' sessions), halt_store, lease_store, plays and totals are each of a
part of them. Imports nothing of the rest. Start with tables.py, then store.py.
"""
