"""Commands about boards: which there are, what they return, how they are made.

Start with boards.py.
"""
