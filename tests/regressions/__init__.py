"""Saved states that once showed a bug, and the tests that replay them."""
