"""UV maps and pictures to paint on."""
