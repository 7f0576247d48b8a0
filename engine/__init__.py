"""The physics of a Plinko board: exact, seeded, replayable bit for bit."""
