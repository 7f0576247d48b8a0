"""HTTP and WebSocket: routes, bodies, middleware, problem details, tokens, limits.

Imports everything below. Start with routes/common.py.
"""
