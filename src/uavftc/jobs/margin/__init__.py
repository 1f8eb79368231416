"""How far a controller is from failing: at which delay, gain, bandwidth or fault the verdict on a scenario changes."""
