"""A class as it is seen by who leads it: small landscapes, the answers, and who moved from wrong to right."""
