"""The folder Points: body points by hand."""
