"""Engines that play the same boards: ours, a tutorial's, and those people would pick.

Each is configured as its expert would; what that took is written at the top of its file. Imports
scenes, harness and the engine. Start with common.py.
"""
