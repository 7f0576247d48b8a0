"""Painting of pixels, palettes, and the bytes of image files.

Imports the theme, and the part of the engine that runs kernels. Start with canvas.py. pixels.py has
the kernels; make.py writes their machine code.
"""
