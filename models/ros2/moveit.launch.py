"""MoveIt and RViz with moveit_resources' panda configuration, and panda-twin instead of ros2_control: ros2 launch moveit.launch.py"""

import pathlib

from launch import LaunchDescription
from launch_ros.actions import Node
from moveit_configs_utils import MoveItConfigsBuilder


def generate_launch_description():
    here = pathlib.Path(__file__).resolve().parent
    config = (
        MoveItConfigsBuilder("moveit_resources_panda")
        .robot_description(file_path="config/panda.urdf.xacro")
        .trajectory_execution(file_path=str(here / "moveit_controllers.yaml"))
        .to_moveit_configs()
    )
    description = [config.robot_description]
    return LaunchDescription([
        Node(package="moveit_ros_move_group", executable="move_group", output="screen", parameters=[config.to_dict()]),
        Node(package="robot_state_publisher", executable="robot_state_publisher", parameters=description),
        Node(package="tf2_ros", executable="static_transform_publisher", arguments=["--frame-id", "world", "--child-frame-id", "panda_link0"]),
        Node(package="rviz2", executable="rviz2", parameters=[config.robot_description, config.robot_description_semantic, config.robot_description_kinematics]),
    ])
