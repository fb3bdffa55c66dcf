"""The recogniser itself: numpy, cv2 and the standard library only; no ROS, no files, no printing."""
