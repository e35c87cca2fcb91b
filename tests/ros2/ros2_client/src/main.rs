//! A node that shares no code with ROS or eProsima: ros2-client on RustDDS. Reads joint states, calls a service and moves all joints by 0.1 rad.
//! Argument: cyclone, for services by a header in the payload.

use std::time::Duration;

use futures::StreamExt;
use ros2_client::{
    action, qos::{Durability, History}, ActionTypeName, Context, ContextOptions, Message, MessageTypeName, Name, NodeName, NodeOptions, QosProfile, ServiceMapping,
    ServiceTypeName,
};
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Stamp { sec: i32, nanosec: u32 }

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Header { stamp: Stamp, frame_id: String }

#[derive(Debug, Clone, Serialize, Deserialize)]
struct JointState { header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64> }
impl Message for JointState {}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct SetBoolRequest { data: bool }
impl Message for SetBoolRequest {}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct SetBoolResponse { success: bool, message: String }
impl Message for SetBoolResponse {}

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Point { positions: Vec<f64>, velocities: Vec<f64>, accelerations: Vec<f64>, effort: Vec<f64>, time_from_start: Stamp }

#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Trajectory { header: Header, joint_names: Vec<String>, points: Vec<Point> }

/// The last five members of a goal, and the multi-DOF ones of feedback, stay empty here: sequences of nothing.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Goal {
    trajectory: Trajectory,
    multi_dof_trajectory: (Header, Vec<String>, Vec<u8>),
    path_tolerance: Vec<u8>,
    component_path_tolerance: Vec<u8>,
    goal_tolerance: Vec<u8>,
    component_goal_tolerance: Vec<u8>,
    goal_time_tolerance: Stamp,
}
impl Message for Goal {}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Outcome { error_code: i32, error_string: String }
impl Message for Outcome {}

type MultiDof = (Vec<u8>, Vec<u8>, Vec<u8>, Stamp);

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Feedback {
    header: Header,
    joint_names: Vec<String>,
    desired: Point,
    actual: Point,
    error: Point,
    multi_dof_joint_names: Vec<String>,
    multi_dof_desired: MultiDof,
    multi_dof_actual: MultiDof,
    multi_dof_error: MultiDof,
}
impl Message for Feedback {}

fn main() {
    let mapping = match std::env::args().nth(1).as_deref() {
        Some("cyclone") => ServiceMapping::Cyclone,
        _ => ServiceMapping::Enhanced,
    };
    let qos = QosProfile::publisher_default().durability(Durability::Volatile).history(History::KeepLast { depth: 10 });
    let domain = std::env::var("ROS_DOMAIN_ID").map_or(0, |text| text.parse().unwrap());
    let context = Context::with_options(ContextOptions::new().domain_id(domain)).unwrap();
    let mut node = context.new_node(NodeName::new("/", "rust_partner").unwrap(), NodeOptions::default()).unwrap();
    smol::spawn(node.spinner().unwrap().spin()).detach();
    let topic = node.create_topic(&Name::new("/", "joint_states").unwrap(), MessageTypeName::new("sensor_msgs", "JointState"), &qos).unwrap();
    let states = node.create_subscription::<JointState>(&topic, None).unwrap();
    let arm = node
        .create_client::<SetBoolRequest, SetBoolResponse>(
            mapping, &Name::new("/panda_twin", "arm").unwrap(), &ServiceTypeName::new("std_srvs", "SetBool"), qos.clone(), qos.clone())
        .unwrap();
    let follow = node
        .create_action_client::<Goal, Outcome, Feedback>(
            mapping,
            &Name::new("/panda_arm_controller", "follow_joint_trajectory").unwrap(),
            &ActionTypeName::new("control_msgs", "FollowJointTrajectory"),
            action::ActionClientQosPolicies {
                goal_service: qos.clone(), result_service: qos.clone(), cancel_service: qos.clone(), feedback_subscription: qos.clone(),
                status_subscription: qos.clone(),
            })
        .unwrap();
    smol::block_on(async {
        let mut stream = Box::pin(states.async_stream());
        let start = stream.next().await.unwrap().unwrap().0;
        println!("state {} {}", start.name.len(), start.name[0]);
        arm.wait_for_service(&node).await;
        let answer = arm.async_call_service(SetBoolRequest { data: false }).await.unwrap();
        println!("service {} {}", answer.success, answer.message);
        let mut goal = Goal::default();
        goal.trajectory.joint_names = start.name[..7].to_vec();
        goal.trajectory.points = vec![Point {
            positions: start.position[..7].iter().map(|q| q + 0.1).collect(),
            time_from_start: Stamp { sec: 2, nanosec: 0 },
            ..Point::default()
        }];
        smol::Timer::after(Duration::from_secs(1)).await; // until the action is matched
        let (id, response) = follow.async_send_goal(goal).await.unwrap();
        println!("accepted {}", response.accepted);
        let feedback = {
            let mut stream = Box::pin(follow.feedback_stream(id));
            stream.next().await.unwrap().unwrap()
        };
        println!("feedback {} {}", feedback.joint_names.len(), feedback.error.positions.len());
        let (status, outcome) = follow.async_request_result(id).await.unwrap();
        println!("result {:?} {} {}", status, outcome.error_code, outcome.error_string);
        let mut end = start.clone();
        for _ in 0..100 {
            end = stream.next().await.unwrap().unwrap().0;
        }
        println!("moved {:.3}", end.position[0] - start.position[0]);
    });
}
