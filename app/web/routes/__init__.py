"""The HTTP and WebSocket interface, one module for each subject.

Routes parse requests and write responses; the decisions are made in the packages below. They may
import everything in app.web and below. Start with common.py.
"""
