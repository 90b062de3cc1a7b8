"""One visitor's page: the loop that carries out what its visitor does, and the schedule of all pages."""
