"""The one decorator of every kernel, and the ways to compile it: fast, or plain.

Imports nothing of the engine. Only fast_compile.py touches numba's insides. Start with
decorator.py, then kernel_compiler.py, which chooses the way.
"""
