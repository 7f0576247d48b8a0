"""For those who run the server: what it counts and what it logs.

Imports nothing of the server.
"""
