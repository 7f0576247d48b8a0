"""The bodies of requests and responses, as they are decoded, encoded and described in OpenAPI.

Imports the protocol, the rooms' limits and the engine. Start with fields.py; body.py decodes.
"""
