"""What links and tabs keep of a page, as text."""
