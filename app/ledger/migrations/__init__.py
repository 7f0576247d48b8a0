"""How the ledger's tables came to be; run by `app.ledger.database.migrate`."""
