"""The paper's figures: each an experiment, its drawing, and what the paper claims of it."""
