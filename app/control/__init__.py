"""What a visitor did and what is due, in order: commands, player, duel, motions, scheduler. Nothing of viser."""
