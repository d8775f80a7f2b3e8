"""Peers: planners, filters, policies and programs of others, run on the arenas, loops and missions of the suites."""
