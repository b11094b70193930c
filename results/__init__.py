"""What was measured, as files, and the figures of the texts that are written from them."""
