"""The pages as they are served: bundled, in each language, with previews for links.

Imports no other package of the server. Start with release.py.
"""
