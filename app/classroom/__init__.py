"""A class on one server: what its pages tell each other through the store, whichever process each of them is in. What a
page does of it is in control/."""
