"""Tests of engine/payouts."""
