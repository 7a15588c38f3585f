"""The daemon as a process, its connection, wire format and client."""
