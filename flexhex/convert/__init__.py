"""`flexhex convert`: a run in another format."""
