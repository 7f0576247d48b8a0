"""Worker processes that compute for requests, with bounded time and memory, so that ticks go on.

Imports the engine, and render for the first picture. Start with pool.py.
"""
