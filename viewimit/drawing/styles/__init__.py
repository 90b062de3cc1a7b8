"""What drawings and the words beside them look like, as style sheets. Not here: their colours, which `theme` has."""
