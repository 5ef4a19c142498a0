"""From pictures to the tone of every outline point."""
