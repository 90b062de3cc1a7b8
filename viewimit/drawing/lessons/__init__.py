"""The drawings that steps of lessons are made of, each of layers that are shown or not: large, with few things on them,
and with the visitor's own mark, in ink. They receive what they show."""
