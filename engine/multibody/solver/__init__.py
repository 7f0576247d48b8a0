"""A frame of balls that touch: broad phase, contacts, times of impact, islands; kernels alone.

Imports physics. Start with step.py.
"""
