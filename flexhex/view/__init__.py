"""`flexhex view`: runs as one offline page, the machine in 3D beside the signals."""
