"""HTTP and WebSocket: what the server answers, and to whom.

routes      one module for each subject; schemas: bodies that several of them share
edge        checks and limits around every request and connection
page        the pages' files: languages, bundled scripts, link previews
services    the objects that the routes use; limits and tokens: what a client may do
problems    turns errors into responses

Imports everything below. Start with routes/common.py.
"""
