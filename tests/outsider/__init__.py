"""What an outsider makes of the pages alone: a decoder and a checker, strangers to the project.

decoder.py and checker.py import the standard library only, which a test checks; the tests beside
them hold both to the server and the engine.
"""
