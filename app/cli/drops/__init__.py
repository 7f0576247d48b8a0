"""Commands that compute drops: one, many, their pictures and proofs. Start with drop.py."""
