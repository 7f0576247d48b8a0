"""Long batches on the command line: computed block by block, saved as they go, shown with the rate.

Imports the engine. Start with running.py.
"""
