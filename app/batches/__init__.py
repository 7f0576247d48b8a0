"""Long batches on the command line: computed block by block, with their result saved regularly.

Imports the engine. Start with running.py.
"""
