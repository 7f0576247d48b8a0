"""A live board: balls in flight, stepped in frames, and the events they make.

Imports drops and solvers. Start with world.py.
"""
