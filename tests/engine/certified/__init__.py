"""Tests of the certified solver against the oracle, and with deliberately wrong laws."""
