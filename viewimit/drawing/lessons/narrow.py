"""Drawings of lessons in a narrow window, as a phone's: their units are its px there, and letters keep their size."""

WIDTH, HALF = 366, 177  # units, of a drawing and of one of two beside each other
CLASS = " vi-narrow"
LETTER = 6.7  # units of a letter there
