"""Tests of the certified solver."""
