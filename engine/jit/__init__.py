"""The one decorator of every kernel, and all that touches numba's insides.

Imports nothing of the engine. Start with decorator.py.
"""
