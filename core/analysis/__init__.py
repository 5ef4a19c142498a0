"""The analysis before a print: where seams and tracelines will show, which way up, and what a texture turns into."""
