"""Shared by tests: ports, waiting, programs, servers, players, and sieges of servers."""
