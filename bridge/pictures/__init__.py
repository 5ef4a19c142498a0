"""Cycles pictures of the predicted print: studio, plastics, views, and how well a printed picture shows."""
