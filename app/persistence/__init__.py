"""The ledger: what must outlive the server. Every accepted drop is here before anyone is told.

service     what is told of the rooms in memory, and when
sessions    what the ledger has heard of each room's session
recovery    how rooms come back from it, or are set aside; rebuild replays one, pure
rebuild_queue  which of them comes back next, in the background
ending      how a session ends that cannot go on: stakes back
audit       every room's record held to its physics, for `plinko ledger check`
room_log    a room's log as it is sent
tables      what is kept, as SQLAlchemy Core tables
store       statements that read
statements  statements that write, in the order of what is handed in
database    opening SQLite or PostgreSQL, and bringing its tables up to date; who may use it
holds       which rooms this server has, where several share the ledger; hold_store its statements
numbers     numbers of sessions that all those servers take from
fence       a number beside SQLite's file: nothing that was committed goes away unnoticed
log_page    a page of a room's log, as another process reads it
integrity   a look at the whole database at the start
migrations  how the tables came to be, step by step, for Alembic
writer      writes and reads as the event loop asks for them, and how long it waits
commit_queue  what waits to be committed, and what becomes of it
committer   the thread that commits it, one transaction for all that waits
null_ledger the same side of it for a server that keeps nothing

Imports rooms (whose records are the rows) and the protocol. Start with service.py.
"""
