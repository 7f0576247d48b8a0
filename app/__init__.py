"""The server: boards, drops and live rooms over HTTP and WebSocket, and the command line.

Imports the engine, never the benchmarks. Start with main.py. The contract in pyproject.toml says
which package may import which.
"""

# Started in a checkout, Python finds this folder as `app`: a second copy of every module.
if __name__ != "plinko.app":
    raise ImportError(f"{__name__} is the source of plinko.app: import plinko.app")
