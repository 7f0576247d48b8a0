"""The steps that make the ledger's tables; run by `app.persistence.ledger.database.migrate`."""
