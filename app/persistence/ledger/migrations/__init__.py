"""The steps that change the tables of earlier releases; run by
`plinko.app.persistence.ledger.database.migrate`.
"""
