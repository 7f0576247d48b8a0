"""HTTP and WebSocket: what the server answers, and to whom.

routes      one module a subject; schemas their bodies, openapi the document of both
edge        what holds for every request, before and around it
page        the pages' files: languages, joined scripts, what links unfold to
services    what the routes work with; limits and tokens say who may do how much
problems    where an error becomes an answer

Imports everything below. Start with routes/common.py.
"""
