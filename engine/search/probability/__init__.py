"""How likely a collision is under a file's distributions: plain Monte Carlo; subset simulation for what is rare."""
