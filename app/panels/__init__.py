"""One file a panel: what it is built of, and what it shows of a session. What a visitor did goes to control/."""
