"""From outlines and fill to the ordered moves of the whole print."""
