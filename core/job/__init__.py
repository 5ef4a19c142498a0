"""How the stages of a job follow one another, what is kept of them, and what they have to tell."""
