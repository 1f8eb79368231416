"""uavftc: fault-tolerant flight control on JSBSim."""

__version__ = "0.1.0"
