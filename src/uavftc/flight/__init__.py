"""From a scenario to a flight, and the flight itself."""
