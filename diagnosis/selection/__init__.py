"""Which hypothesis explains what repeats on motions that it has not seen; see
docs/decisions/0009-selection.md."""
