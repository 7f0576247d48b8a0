"""Payout tables with a measured return: counts where drops land, and solves the multipliers.

May import the board and drops. Read `engine/payouts/solve.py` first. It gets the counts from
`landings.py`, the multipliers from `table.py`, and the odds that a player sees from `odds.py`.
"""
