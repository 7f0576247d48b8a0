"""The project's benchmarks: error, speed, stability, and the load that a server can take.

Each package answers one question. All share harness/, scenes/ and contestants/, and import the
engine and the server. A contestant that may not be installed is imported only when it is used.
Start with __main__.py, the command line; suite.py names every benchmark.
"""
