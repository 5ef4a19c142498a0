"""What a print takes: time, filament, money, and the same for one colour."""
