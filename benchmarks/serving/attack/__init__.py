"""What players notice while a server is attacked. Start with attack.py."""
