"""What the controller is shown."""
