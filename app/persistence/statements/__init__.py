"""The ledger's tables and all statements over them. The caller opens the connection.

`tables` declares them for SQLAlchemy Core; `store` reads; `writing` applies writes in order;
`retention` deletes what is old. The other modules each have the statements of one part: fair
sessions, leases, webhooks, writers, a player's history (`plays`) and sums (`totals`). Imports
nothing from the rest of the package. Start with tables.py, then store.py.
"""
