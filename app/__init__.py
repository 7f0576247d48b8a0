"""The server: boards, drops and live rooms over HTTP and WebSocket, and the command line."""
