"""Golden files (known good outputs), and the program that makes the sessions among them."""
