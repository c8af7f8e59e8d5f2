"""Serial protocol stacks, sans-IO: bytes and a time in, frozen events out. Nothing here opens a port or reads a clock."""
