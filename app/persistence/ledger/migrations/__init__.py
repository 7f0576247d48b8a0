"""How the ledger's tables came to be; run by `app.persistence.ledger.database.migrate`."""
