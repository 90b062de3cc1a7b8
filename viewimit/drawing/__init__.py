"""SVG and HTML of all that is seen, on the page and in files: each figure is drawn once, from what it is given. Nothing
is fitted, projected or analysed here."""
