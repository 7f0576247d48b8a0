"""The cost of the server and its pages: streams, pictures, idle rooms, attacks.

Imports the harness, the server and the engine. Start with stream.py.
"""
