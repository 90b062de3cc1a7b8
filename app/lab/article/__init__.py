"""The article's live figures: their modules, and the script and styles that pages load."""
