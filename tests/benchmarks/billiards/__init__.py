"""Balls with a velocity, without bins: one path, and flows of many on boards that repeat."""
