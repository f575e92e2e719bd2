"""Plans with a Clearway planner on a map of ROS 2; see ``docs/clients.md``."""
