"""`flexhex plot`: signals of a run at a glance."""
