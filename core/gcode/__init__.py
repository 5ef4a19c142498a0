"""G-code in MakerBot's dialect, as for the Replicator 2X, and in Marlin's and Klipper's."""
