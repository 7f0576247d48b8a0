"""Routes for rooms, over REST and WebSocket, for players and for the operator.

Imports routes/common.py. Start with rooms.py; ws.py is the WebSocket.
"""
