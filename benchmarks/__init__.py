"""What the project measures of itself: error, speed, stability, and what a server bears.

One package a question; they share harness/, scenes/ and contestants/, and import the engine and the
server. Contestants that may be missing are imported when asked for. Start with __main__.py,
which is the command line; suite.py names every benchmark.
"""
