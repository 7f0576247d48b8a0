"""The certified solver held against the oracle and against itself with a law broken."""
