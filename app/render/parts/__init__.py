"""Parts of pictures: the layout, the board, balls, paths and captions.

Imports raster and the engine. Start with view.py.
"""
