"""Commands of the page, the lab, the class and their documents: add_options(parser), and run(args) -> exit status."""
