"""The live table in a real Chromium: play, motion, instruments, lines that break."""
