"""What is asked of rooms: over REST, over WebSocket, by players and by who runs the server.

Imports common.py beside it. Start with rooms.py; ws.py is the socket.
"""
