"""The server: boards, drops and live rooms over HTTP and WebSocket, and the command line.

Imports the engine, never the benchmarks. Start with main.py; the packages' order, and which may
import which, is the contract in pyproject.toml.
"""
