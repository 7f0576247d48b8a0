"""What Alembic runs: the steps over the connection that the database's `migrate` hands it."""

from alembic import context

from app.persistence.statements.tables import metadata

connection = context.config.attributes["connection"]
context.configure(connection=connection, target_metadata=metadata, transactional_ddl=True)
with context.begin_transaction():
    context.run_migrations()
