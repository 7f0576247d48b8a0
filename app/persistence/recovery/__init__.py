"""Restores rooms from the ledger, ends runs that cannot continue, and sets damaged rooms aside.

recovery.py finds and restores rooms, rebuild.py replays one (pure), rebuild_queue.py orders the
rebuilds in the background, ending.py ends a run that cannot continue, salvage.py reads a damaged
list of rooms. Imports the ledger and its statements. Start with recovery.py.
"""
