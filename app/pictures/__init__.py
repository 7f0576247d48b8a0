"""Pictures made on request: a cache of pictures, and live pictures of rooms.

Imports render and rooms. Start with film.py.
"""
