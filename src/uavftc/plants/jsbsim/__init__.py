"""The JSBSim plant: the only part of the project that imports jsbsim."""
