"""What lies over a drawing of the page: links by which it is touched, and what they show. No file has them."""
