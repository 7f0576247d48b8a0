"""Tests of the live table in a real Chromium: play, motion, instruments, lost connections."""
