"""The arrays of the solver, one table a file: its columns, and the named tuple that carries it.

A column is written with its module, `pos[i, body.X]`, `items[k, shape.X1]`: tables share names.
Imports nothing of the project. Start with body.py.
"""
