"""What is true: robot, camera, signals."""
