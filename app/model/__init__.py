"""What a page is about, without its widgets: a session, how fast it runs, how it is shown, and what goes with it."""
