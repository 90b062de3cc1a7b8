"""Body points by hand: placed, removed and proposed on the page; layouts to choose from. Their widgets
are in panels/."""
