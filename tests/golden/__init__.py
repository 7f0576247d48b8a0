"""Known good outputs, and what makes and compares them."""
