"""X3G, the binary file that the Replicator 2X reads from its card."""
