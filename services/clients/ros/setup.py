from setuptools import setup

setup(
    name="clearway_ros",
    version="0.1.0",
    description="Plans with a Clearway planner on a map of ROS 2",
    license="MIT OR Apache-2.0",
    packages=["clearway_ros"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/clearway_ros"]),
        ("share/clearway_ros", ["package.xml"]),
        ("share/clearway_ros/rviz", ["rviz/clearway.rviz"]),
    ],
    python_requires=">=3.11",
    # ROS itself is no package of pip on most machines.
    install_requires=["setuptools", "clearway", "numpy"],
    zip_safe=False,
    entry_points={"console_scripts": ["clearway_ros = clearway_ros.node:main"]},
)
