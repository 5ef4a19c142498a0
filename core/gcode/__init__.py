"""G-code for the Replicator 2X."""
