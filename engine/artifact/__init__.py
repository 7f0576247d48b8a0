"""The exact solver's kernels as one WebAssembly file, the same bytes wherever a drop is computed.

Imports the exact solver, to make the file, and what it needs to run it. Start with entries.py, what
the file exports; make.py writes it and host.py runs it, without numba.
"""
