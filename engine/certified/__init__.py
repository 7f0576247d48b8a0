"""The certified solver: the same laws in ball arithmetic, every comparison proven.

Imports the exact solver's drops, to compare with them, and python-flint (extra `certify`), which no
other package imports. No other package of the engine imports this one. Start with certify.py, then
trace.py.
"""
