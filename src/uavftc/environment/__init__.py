"""What the scenario prescribes over time: references, faults, disturbances, air."""
