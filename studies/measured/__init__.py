"""Measured machines of other people's publications: what flexhex says of them, beside what a lab
would use instead, on the same files."""
