"""A step of balls that touch each other, as kernels: broad phase to position projection.

Imports physics. Start with step.py; layout/ says what the arrays hold.
"""
