"""What a print takes: time, filament and money; and the time that the same object takes in one color."""
