"""Force balance: friction, mass and offset by regression on a measured force."""
