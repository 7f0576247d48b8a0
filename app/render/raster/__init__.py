"""Pixels and the bytes of image files: painting with coverage, palettes, GIF, PNG.

Imports the theme alone. Start with canvas.py.
"""
