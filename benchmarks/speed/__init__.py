"""How fast the engine is, and what each feature costs. Start with throughput.py."""
