"""A server attacked: what its other players notice. Start with attack.py."""
