"""The same suites on the same boards through each door: memory, pty, TCP, RFC 2217 and the proxy."""
