"""Checks and limits in front of the application: connections, heads, hosts and proxies.

Imports app.errors and app.web.problems. Start with connection.py, then guarded.py.
"""
