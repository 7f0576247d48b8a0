"""How rooms come back from the ledger, and what becomes of one that cannot.

recovery.py finds and restores them, rebuild.py replays one (pure), rebuild_queue.py says which is
next in the background, ending.py ends a run that cannot go on, salvage.py reads damaged pages.
Imports the ledger and its statements. Start with recovery.py.
"""
