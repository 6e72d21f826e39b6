"""Out of the house: a model for a controller, a drive, a simulator. One file a target."""
