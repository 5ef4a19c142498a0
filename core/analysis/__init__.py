"""The analysis before a print: where seams and tracelines will show, and which way up the object shows its picture best."""
