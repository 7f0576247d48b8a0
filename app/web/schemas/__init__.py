"""The bodies of requests and replies: what is decoded, encoded, and told by OpenAPI.

Imports the protocol, the rooms' limits and the engine. Start with fields.py; body.py decodes.
"""
