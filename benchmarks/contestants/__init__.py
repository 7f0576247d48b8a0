"""Engines that play the same boards: ours, a tutorial's, and the popular ones.

Each is configured as its expert would do it; the top of its file says how. Imports scenes, harness
and the engine. Start with common.py.
"""
