"""The certified solver: the same laws in ball arithmetic, every comparison proven.

Uses drops to compare with, and python-flint (extra `certify`), which nothing else imports; nothing
in the engine depends on it. Start with certify.py, then trace.py.
"""
