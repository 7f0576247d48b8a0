"""The ledger: what must outlive the server. Every accepted drop is here before anyone is told.

tables      what is kept, as SQLAlchemy Core tables
records     the same as frozen values, which is what the rest of the server sees
store       statements: values in and out over a connection
database    opening SQLite or PostgreSQL, one server at a time, and bringing its tables up to date
migrations  how the tables came to be, step by step, for Alembic
writer      one thread, one commit for all that waits, failures and recovery
"""
