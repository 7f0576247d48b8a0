"""Tests of the page, played in a real Chromium against a running server."""
