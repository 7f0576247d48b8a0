"""Pixels and the bytes of image files: painting with coverage, palettes, GIF, PNG.

Imports the theme, and of the engine what runs kernels. Start with canvas.py; pixels.py has the
kernels, whose machine code make.py writes.
"""
