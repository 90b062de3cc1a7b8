"""How many connections there may be, whose they are, and how long each may take."""
