"""One file for each step. A released step never changes; a later step fixes its faults."""
