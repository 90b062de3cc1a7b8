"""One visitor's page."""
