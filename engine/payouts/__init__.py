"""Payout tables that return what they say: where drops land, counted, and what bins then pay.

May import the board and drops. Read `engine/payouts/solve.py` first: it asks `landings.py` for
counts, `table.py` for multipliers and `odds.py` for what a player is told of them.
"""
