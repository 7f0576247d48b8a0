"""A decoder and a checker as an outsider would write them, using only the documentation.

decoder.py and checker.py import only the standard library, which a test checks. The tests in this
folder compare both with the server and the engine.
"""
