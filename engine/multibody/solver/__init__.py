"""The kernels that advance balls that touch each other, from broad phase to position projection.

Imports physics. Start with step.py; layout/ describes the arrays.
"""
