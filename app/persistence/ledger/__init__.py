"""The database, and the one thread that writes to it: one commit for all jobs that wait.

database       opens, locks and migrates SQLite or PostgreSQL
migrations     the steps that change the tables of earlier releases, for Alembic
writer         the event loop's interface: writes, reads, and time limits
commit_queue   the jobs that wait for a commit, and the fate of each
committer      the thread that commits them
epoch          the file next to the ledger, which detects lost commits and restored backups
common_secrets the secrets with which servers that share the ledger sign

Imports the statements. Start with writer.py.
"""
