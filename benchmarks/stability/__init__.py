"""Scenes made to break a solver; what must never happen is counted. Start with stability.py."""
