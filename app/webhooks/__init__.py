"""Tells other programs of drops and landings: each target hears of all of them, in order.

What is to be told is written down with the drop or the result itself (`statements.webhook_store`),
so a server that ends in between tells it after its next start. Start with sender.py.
"""
