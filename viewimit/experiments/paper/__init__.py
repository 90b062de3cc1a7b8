"""The paper's figures: each an experiment, its drawing, and what the paper claims of it. Studies of our own are in
bench/."""
