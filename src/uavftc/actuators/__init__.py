"""The chain on a surface, one stage a file: delay, saturation, effectiveness and bias, stops."""
