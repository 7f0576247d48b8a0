"""Work in processes of its own, so that the ticker never waits for it; bounded in time and memory.

Imports the engine, and render when a picture is asked for. Start with pool.py.
"""
