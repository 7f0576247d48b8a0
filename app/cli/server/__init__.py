"""Commands that run a server, or ask something of one or of its ledger. Start with serve.py."""
