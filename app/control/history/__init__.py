"""What a page can go back to: what a change to its session loses, and what was there before a word was shown.
Motions that are undone are the session's own."""
