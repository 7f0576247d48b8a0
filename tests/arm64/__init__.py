"""arm64: the digests under an emulated processor. check builds what it needs and runs them."""
