"""Golden files (known good outputs), and the programs that make and compare them."""
