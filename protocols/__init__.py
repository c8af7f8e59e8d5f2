"""Serial protocol stacks, sans-IO: bytes and a time in, frozen events out; no port and no clock."""
