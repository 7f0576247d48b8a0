"""The arrays of the solver: each file has the columns of some arrays and a named tuple of these.

Code names a column with its module, such as `pos[i, body.X]`, because files share column names.
Imports nothing of the project. Start with body.py.
"""
