"""Numba functions on scalars and arrays: + - * / and sqrt on float64, in a fixed order."""
