"""Objects that the program makes: picture objects, the calibration tile, the sample."""
