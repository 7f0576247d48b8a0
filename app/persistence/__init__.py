"""The ledger: what must outlive the server. Every accepted drop is here before anyone is told.

service     what is told of the rooms in memory, and when
room_runs   what the ledger has heard of each run of a room
leases      which rooms this server has, where several share the ledger: lease_book knows, leases
            takes them; numbers are those of runs
room_log    a room's log as it is sent; log_page a page of it, as another process reads it
ledger      the database, and the thread that commits
statements  what is read and written there
recovery    how rooms come back from it, or are set aside
checks      whether what it holds is whole and true

Imports rooms (whose records are the rows) and the protocol. Start with service.py.
"""
