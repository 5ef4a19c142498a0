"""The analysis before a print: where seams and tracelines will show, and which way up shows the picture best."""
