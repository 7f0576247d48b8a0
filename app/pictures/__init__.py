"""Pictures made while the server runs: the cache, the film of a room and its thread.

Imports render and rooms. Start with film.py.
"""
