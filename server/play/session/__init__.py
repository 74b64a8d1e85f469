"""One game in this process: its clock, its player, rewinding."""
