"""A simulated laboratory: a robot with wheels on a floor, and a camera above it, in MuJoCo."""
