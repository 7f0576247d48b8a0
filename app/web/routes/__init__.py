"""The HTTP and WebSocket interface, one module a subject.

Routes carry out; others decide. They import everything in app.web and below. Start with common.py.
"""
