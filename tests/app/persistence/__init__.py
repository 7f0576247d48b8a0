"""The ledger: on SQLite and PostgreSQL, through failures, crashes and restarts."""
