"""What tests share: ports, waiting, programs, servers, players, and sieges of servers."""
