"""What the server and its pages cost: streams, pictures, idle rooms. Start with stream.py."""
