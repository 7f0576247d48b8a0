"""What pictures are made of: the board, balls, paths, captions, and where they lie.

Imports raster and the engine. Start with view.py.
"""
