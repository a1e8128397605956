"""Parameter files for ros2_controllers."""
