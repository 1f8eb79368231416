"""Inner loop: body-rate command to deflections."""
