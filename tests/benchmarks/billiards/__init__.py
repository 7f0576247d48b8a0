"""Tests of billiards: the path of one ball, and flows of many balls on boards that repeat."""
