"""Who watches which room, and what they are sent: encoded once, whoever is slow waits for nobody.

Imports the protocol. Start with audience.py; hub.py has the clients, transport.py their sockets.
"""
