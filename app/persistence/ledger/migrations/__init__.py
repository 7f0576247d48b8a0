"""The steps that make the ledger's tables; run by
`plinko.app.persistence.ledger.database.migrate`.
"""
