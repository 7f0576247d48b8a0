"""The server: boards, drops and live rooms over HTTP and WebSocket, and the command line.

Imports the engine, never the benchmarks. Start with main.py. The contract in pyproject.toml says
which package may import which.
"""
