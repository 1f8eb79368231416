"""The control laws: outer loop on the attitude, inner loop on the body rates."""
