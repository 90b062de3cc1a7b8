"""A class: who is in it, what they are asked and answer, and the server that carries this between their browsers.

The lessons run in the browsers themselves, in the lab."""
