"""Oracles: the truth about tubes, sets, rooms and loops, derived once more, which certificates are compared with."""
