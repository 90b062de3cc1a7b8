"""The engine of guided lessons, whose content is data: what a step asks before it shows, what was answered, and the
drawings that a step is made of. No widgets, and no step, in here."""
