"""Commands about boards: list them, count their returns, make new ones. Start with boards.py."""
