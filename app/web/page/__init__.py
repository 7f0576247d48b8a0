"""The pages as they are served: in a language, each as one script and one sheet; and their links.

Imports nothing of the rest. Start with release.py.
"""
