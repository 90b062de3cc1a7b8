"""A class as it is seen by who leads it: small landscapes, what was answered, and who moved from wrong to right."""
