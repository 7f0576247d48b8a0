"""The boards and scenes that benchmarks and tests share. Start with boards.py."""
