"""Saved states in which a bug once showed, and the test that plays them again."""
