"""The ledger: all data that must outlive the server. Each drop is committed before it is announced.

service     what to write about the rooms in memory, and when
room_runs   how much of each room run has been written
leases      which rooms this server has, if several share the ledger; without I/O: lease_book
room_log    streams a room's log, whose pages may be read in another process
ledger      the database, and the thread that commits
statements  the statements that read and write it
recovery    restores rooms from the ledger, and sets damaged ones aside
checks      checks that the ledger is complete and correct

Imports rooms (whose records are the rows) and the protocol. Start with service.py.
"""
