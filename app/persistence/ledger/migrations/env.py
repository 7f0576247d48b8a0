"""Alembic's entry point: runs the steps over the connection from `database.migrate`."""

from alembic import context

from plinko.app.persistence.statements.tables import metadata

connection = context.config.attributes["connection"]
context.configure(connection=connection, target_metadata=metadata, transactional_ddl=True)
with context.begin_transaction():
    context.run_migrations()
