"""Sends every drop and landing to other programs: to each target all of them, in order.

An event is committed together with its drop or result (`statements.webhook_store`). If the server
ends before it has sent the event, it sends it after its next start. Start with sender.py.
"""
