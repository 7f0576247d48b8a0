"""What the server and its pages cost: streams, pictures, idle rooms.

Imports the harness, the server and the engine. Start with stream.py.
"""
