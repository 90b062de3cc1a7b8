"""One file a command: add_options(parser), and run(args) -> exit status. What it prints is computed elsewhere."""
