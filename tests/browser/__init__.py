"""Tests of the pages in a real Chromium, with a running server."""
