"""Commands that run a server or a relay, or work on a server's ledger. Start with serve.py."""
