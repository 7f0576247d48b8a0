"""The two solvers: `exact`, event by event, and `stepped`, by fixed steps."""
