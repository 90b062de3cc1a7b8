"""A class: its members, questions and answers, and the server that passes them between the browsers. The lessons run in
the browsers themselves, in the lab."""
