"""Metrics and log lines for operators of the server.

Imports nothing of the server.
"""
