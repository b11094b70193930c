"""Which hypothesis explains what repeats on motions that it has not seen; see docs/method.md."""
