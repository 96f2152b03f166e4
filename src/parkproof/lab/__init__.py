"""The laboratory: from pixels to parked, under any overhead camera, with a tag on the robot."""
