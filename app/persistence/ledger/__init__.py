"""The database and who writes to it: one thread, one commit for all that waits.

database       opening SQLite or PostgreSQL, and bringing its tables up to date; who may use it
migrations     how its tables came to be, step by step, for Alembic
writer         writes and reads as the event loop asks for them, and how long it waits
commit_queue   what waits to be committed, and what becomes of it
committer      the thread that commits it, one transaction for all that waits
null_ledger    the same side of it for a server that keeps nothing
fence          a number beside SQLite's file: nothing that was committed goes away unnoticed
common_secrets what servers that share it sign with

Imports the statements. Start with writer.py.
"""
