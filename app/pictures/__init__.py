"""Pictures made while the server runs: worker threads, the cache, the film of a room.

Imports render and rooms. Start with film.py.
"""
