"""What stands before the application: connections, heads, hosts and proxies, and their limits.

Imports app.errors and app.web.problems. Start with guarded.py; hosts.py says who may be asked for.
"""
