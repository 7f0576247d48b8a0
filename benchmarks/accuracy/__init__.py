"""Run time against error: who finds the true path, and at what price. Start with accuracy.py."""
