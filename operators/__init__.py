"""One user action each: read the settings, call the pipeline, report."""
