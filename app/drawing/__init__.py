"""Drawings of the page alone: what lies over the library's drawings, the race, the bars beside the sliders."""
