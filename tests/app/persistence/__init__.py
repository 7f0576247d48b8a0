"""Tests of the ledger on SQLite and PostgreSQL, with failures, crashes and restarts."""
