"""One class for each thing a visitor can do: made from what a browser sent, carried out on the page's model."""
