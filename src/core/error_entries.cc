#include "core/error_entries.h"

// A data table, hence longer than other files. Meanings follow FCI protocol 5, error table and
// conditions; twin/onboard documents how values are computed and which figures are decisions.
namespace twin {
namespace {

constexpr std::string_view kUnsmooth =
    "the commands that reached the robot were not smooth: a step in the stream, samples taken at "
    "uneven times (4 us at 1 rad/s make 12000 rad/s^3), a source slower than 1 kHz that is held "
    "from cycle to cycle, or a command that has to close the gap which lost commands left";
constexpr std::string_view kSmooth =
    "start from the state's last commanded value, go on from it every cycle by what the limits "
    "allow, and stop with velocity and acceleration at zero; filter or limit what a source "
    "delivers; lose fewer commands, or move more gently";
constexpr std::string_view kSmoothInScenario =
    "leave tick.generator and tick.viability out: their defaults resample the targets and keep the "
    "limits; behind another generator say tick.viability: 19, or tick.limiter: true, lose fewer "
    "messages (link), or move more gently";
constexpr std::string_view kSmoothInRealtime =
    "leave tick.generator and tick.viability out: their defaults resample the targets and keep the "
    "limits; what remains comes from threads that ran late: panda-twin check says how well this "
    "host keeps time";
constexpr std::string_view kSingular =
    "the end effector's motion was within its limits, but asked too much of the joints: near a "
    "singularity (arm stretched, wrist aligned) or a joint's limit a small motion of the hand "
    "takes "
    "a large one of the joints";
constexpr std::string_view kAwayFromSingular =
    "lead the path away from singularities and joint limits, give it an elbow, slow it down there, "
    "or command the joints instead";
constexpr std::string_view kMoreTime = "give the motion more time";
constexpr std::string_view kCollision =
    "the arm ran into something, or was pushed; without contact, an acceleration or a load that "
    "the "
    "robot does not know of can do it, with thresholds set low";
constexpr std::string_view kNoCollision =
    "clear the way; if the contact is meant, raise the thresholds (SetCollisionBehavior) above it "
    "before the motion; tell the robot its load (SetLoad); accelerate less";
constexpr std::string_view kNoCollisionInRun =
    "onboard.collision_behavior sets the thresholds, onboard.load what the robot believes it "
    "carries";
constexpr std::string_view kStableInRun =
    "onboard.K_theta, onboard.K_x and onboard.damping_ratio are the controller's, onboard.load "
    "what it believes it "
    "carries; plant.armature and plant.mass_scale make the arm another than the one it is made for";
constexpr std::string_view kOwnMotion =
    "it belongs to the robot's own motions, which its Desk interface plans and runs; motions over "
    "FCI stream their commands, and the robot plans nothing";

}  // namespace

const std::array<ErrorEntry, kRobotErrorCount> kErrorEntries{{
    // 0 joint_position_limits_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was measured beyond its position limit",
     .quantity = "measured position",
     .units = {"rad"},
     .computed = "q of the state, against the joint's limits widened by a margin",
     .cause =
         "the arm was pushed there or its torques drove it there, or the reference came closer "
         "to the limit than the arm follows it",
     .cure =
         "keep the motion further away from the joint's limit than the arm's tracking error; with "
         "torques of your own, push back before the limit. Automatic recovery cannot free the "
         "arm: it has to be led back by hand"},
    // 1 cartesian_position_limits_violation
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "A part of the robot would leave a region of the lab's limits",
     .quantity = "reach of the part along the region's border",
     .units = {"m"},
     .computed =
         "end effector, elbow or hand along the normal of the plane that the stop after this "
         "cycle would pass, in the base's frame; only with serve --guard",
     .cause =
         "the commands went on towards the border until the arm could only just stop before it",
     .cure = "slow down before the border, or lead the motion away from it; panda-twin validate "
             "checks a scenario against the same limits. On a real robot: a virtual wall of its "
             "Desk interface"},
    // 2 self_collision_avoidance_violation
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "The arm was about to collide with itself",
     .quantity = "clearance between two of its bodies",
     .units = {"m"},
     .computed =
         "the least distance of the arm's parts that can meet, as capsules about its links, at the "
         "measured q; negative: they overlap",
     .cause = "the motion folds the arm onto itself: hand against base or forearm",
     .cure = "lead the path further away from the arm's own base and links; Cartesian motions also "
             "need an elbow that does"},
    // 3 joint_velocity_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was measured to move faster than it may",
     .quantity = "measured velocity",
     .units = {"rad/s"},
     .computed = "dq of the state, against the joint's velocity limit widened by a margin",
     .cause = "torques drove the joint too fast, something struck the arm, or a reference at its "
              "limit was followed with overshoot",
     .cure = "damp what a controller of torques does, and keep references a few percent below the "
             "velocity limit"},
    // 4 cartesian_velocity_violation
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The end effector was measured to move faster than it may",
     .quantity = "measured speed",
     .units = {"m/s", "rad/s", "rad/s"},
     .computed = "the norm of the upper or lower half of J(q) dq, J that of EE in base axes; "
                 "against bounds "
                 "above those of commands, of rotation in Cartesian motions only",
     .cause = "several joints at speeds that each are allowed add up at the hand; torques, or "
              "something that struck the arm",
     .cure =
         "give the motion more time where the arm is stretched out, and damp what a controller of "
         "torques does"},
    // 5 force_control_safety_violation
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "An external force or torque was above a cap of the lab's limits",
     .quantity = "external force on the end effector, or torque on a joint",
     .units = {"N or Nm"},
     .computed = "the norm of the force in O_F_ext_hat_K, or tau_ext_hat_filtered; only with serve "
                 "--guard",
     .cause = kCollision,
     .cure = kNoCollision},
    // 6 joint_reflex
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "An external torque on a joint was above its collision threshold",
     .quantity = "external torque",
     .units = {"Nm"},
     .computed =
         "tau_ext_hat_filtered, which an observer of the arm's momentum estimates; against "
         "the upper torque threshold, that for accelerating while the reference accelerates; with "
         "and without a motion",
     .cause = kCollision,
     .cure = kNoCollision,
     .in_scenario = kNoCollisionInRun,
     .in_realtime = kNoCollisionInRun},
    // 7 cartesian_reflex
    {.raised = true,
     .axis = AxisKind::kWrench,
     .meaning = "An external force on the end effector was above its collision threshold",
     .quantity = "external force",
     .units = {"N", "Nm"},
     .computed =
         "K_F_ext_hat_K, from the external joint torques through the Jacobian of K; against "
         "the upper force threshold, that for accelerating while the reference accelerates; with "
         "and "
         "without a motion",
     .cause = kCollision,
     .cure = kNoCollision,
     .in_scenario = kNoCollisionInRun,
     .in_realtime = kNoCollisionInRun},
    // 8 max_goal_pose_deviation_violation
    {.meaning = "A motion ended further from its goal than the Move request allows",
     .cause = "a streamed motion has no goal that the robot knows of; clients send deviations that "
              "allow everything, and libfranka offers no others"},
    // 9 max_path_pose_deviation_violation
    {.meaning = "A motion left its path by more than the Move request allows",
     .cause = "a streamed motion has no path that the robot knows of; clients send deviations that "
              "allow everything, and libfranka offers no others"},
    // 10 cartesian_velocity_profile_safety_violation
    {.meaning = "The velocity profile of a motion was exceeded", .cause = kOwnMotion},
    // 11 joint_position_motion_generator_start_pose_invalid
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "The first joint position of a motion was too far from where the robot is",
     .quantity = "distance of the first command",
     .units = {"rad"},
     .computed = "|q_c - q_d| at the first command of the motion",
     .cause = "the motion was planned from another pose than the robot is in, or its values are of "
              "other joints or in degrees",
     .cure = "let the first command be the state's q_d, and the motion go on from there",
     .in_scenario =
         "let the trajectory start where the robot is (robot.q_start), or leave q_start out",
     .in_realtime =
         "let the trajectory start where the robot is (robot.q_start), or leave q_start out"},
    // 12 joint_motion_generator_position_limits_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was commanded beyond its position limit",
     .quantity = "position",
     .units = {"rad"},
     .computed = "the commanded position, or the integral of the commanded velocity",
     .cause =
         "the path leads there; or, of velocities, they add up to it; or the last acceleration, "
         "held while commands were lost, carried on to it",
     .cure =
         "keep the motion further away from the joint's limit; limit velocities by the room that "
         "is left"},
    // 13 joint_motion_generator_velocity_limits_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was commanded to move faster than it may",
     .quantity = "velocity",
     .units = {"rad/s"},
     .computed = "(q_c - q_d) / 1 ms, or the commanded velocity",
     .cause = "the motion is too fast; or the last acceleration, held while commands were lost, "
              "carried on beyond the limit",
     .cure = kMoreTime},
    // 14 joint_motion_generator_velocity_discontinuity
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was commanded an acceleration above its limit",
     .quantity = "acceleration",
     .units = {"rad/s^2"},
     .computed = "(dq - dq_d) / 1 ms, dq = (q_c - q_d) / 1 ms or the commanded velocity",
     .cause = kUnsmooth,
     .cure = kSmooth,
     .in_scenario = kSmoothInScenario,
     .in_realtime = kSmoothInRealtime},
    // 15 joint_motion_generator_acceleration_discontinuity
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint was commanded a jerk above its limit",
     .quantity = "jerk",
     .units = {"rad/s^3"},
     .computed = "(ddq - ddq_d) / 1 ms, ddq = (dq - dq_d) / 1 ms, dq = (q_c - q_d) / 1 ms or the "
                 "commanded velocity",
     .cause = kUnsmooth,
     .cure = kSmooth,
     .in_scenario = kSmoothInScenario,
     .in_realtime = kSmoothInRealtime},
    // 16 cartesian_position_motion_generator_start_pose_invalid
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The first pose of a motion was too far from where the robot is",
     .quantity = "distance of the first command",
     .units = {"m", "rad", "rad"},
     .computed =
         "at the first command of the motion, the distance of O_T_EE_c from the last O_T_EE_c "
         "of the state: of the origins, or the angle between the rotations",
     .cause = "the motion was planned from another pose than the robot is in, or for another end "
              "effector frame",
     .cure = "let the first command be the state's O_T_EE_c, and the motion go on from there"},
    // 17 cartesian_motion_generator_elbow_limit_violation
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The elbow was commanded beyond its limit",
     .quantity = "elbow angle",
     .units = {"rad", "rad", "rad"},
     .computed = "elbow_c, the commanded position of joint 3, against that joint's limits",
     .cause = "the commanded elbow leads there; or its last acceleration, held while commands were "
              "lost, carried on to it",
     .cure = "keep the elbow further away from the limits of joint 3"},
    // 18 cartesian_motion_generator_velocity_limits_violation
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The end effector or the elbow was commanded to move faster than it may",
     .quantity = "speed",
     .units = {"m/s", "rad/s", "rad/s"},
     .computed =
         "the norm of (p_c - p) / 1 ms, of log(R_c R^T) / 1 ms, or of the commanded twist's "
         "part; elbow: |elbow_c - last elbow_c| / 1 ms",
     .cause = "the motion is too fast; or the last acceleration, held while commands were lost, "
              "carried on beyond the limit",
     .cure = kMoreTime},
    // 19 cartesian_motion_generator_velocity_discontinuity
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The end effector or the elbow was commanded an acceleration above its limit",
     .quantity = "acceleration",
     .units = {"m/s^2", "rad/s^2", "rad/s^2"},
     .computed =
         "the norm of (dp - O_dP_EE_c) / 1 ms, dp the new velocity by difference quotient or "
         "as commanded; elbow: |delbow - delbow_c| / 1 ms",
     .cause = kUnsmooth,
     .cure = kSmooth,
     .in_scenario = kSmoothInScenario,
     .in_realtime = kSmoothInRealtime},
    // 20 cartesian_motion_generator_acceleration_discontinuity
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The end effector or the elbow was commanded a jerk above its limit",
     .quantity = "jerk",
     .units = {"m/s^3", "rad/s^3", "rad/s^3"},
     .computed =
         "the norm of (ddp - O_ddP_EE_c) / 1 ms, ddp = (dp - O_dP_EE_c) / 1 ms, dp the new "
         "velocity by difference quotient or as commanded; elbow: |ddelbow - ddelbow_c| / 1 ms",
     .cause = kUnsmooth,
     .cure = kSmooth,
     .in_scenario = kSmoothInScenario,
     .in_realtime = kSmoothInRealtime},
    // 21 cartesian_motion_generator_elbow_sign_inconsistent
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "The elbow was commanded with a sign that is not the arm's",
     .quantity = "commanded sign of the elbow",
     .units = {},
     .computed =
         "elbow_c[1], against the sign of the arm: -1 while q_d of joint 4 is below -0.467 rad, as "
         "in all usual poses, +1 above",
     .cause = "the elbow was filled in by hand, or planned for an arm folded the other way",
     .cure = "take the sign from the state's elbow_c when the motion starts, and keep it"},
    // 22 cartesian_motion_generator_start_elbow_invalid
    {.raised = true,
     .axis = AxisKind::kMotion,
     .meaning = "The first elbow of a motion was too far from where the robot's is",
     .quantity = "distance of the first elbow",
     .units = {"rad", "rad", "rad"},
     .computed = "|elbow_c - last elbow_c of the state| at the first command with an elbow",
     .cause = "the motion was planned from another pose than the robot is in",
     .cure = "let the first command be the state's elbow_c, and the motion go on from there"},
    // 23 force_controller_desired_force_tolerance_violation
    {.meaning = "The desired force of a force controller was beyond its safety threshold",
     .cause =
         "it belongs to the force controllers behind the robot's Desk interface; over FCI, forces "
         "are controlled by torques of the client's"},
    // 24 start_elbow_sign_inconsistent
    {.meaning = "A motion started with an elbow of the wrong sign", .cause = kOwnMotion},
    // 25 communication_constraints_violation, commands lost in a row
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "Too many commands in a row did not reach the robot in time",
     .quantity = "cycles in a row without a command",
     .units = {},
     .computed =
         "a command counts when it answers the last state and arrives before the deadline of "
         "the next cycle; what comes later, twice or with another id is dropped",
     .cause =
         "the workstation was held up, the network lost or delayed packets, or the whole round "
         "(state, computation, command) takes more than 1 ms",
     .cure =
         "keep the round below 1 ms, and what a cycle computes below about 0.3 ms; nothing that "
         "waits or allocates in the loop; a real-time kernel, a network of its own",
     .in_scenario =
         "a command counts only when state delay + tick.cost + command delay + link.d_INT "
         "stay below 1 ms: lower the delays or the losses",
     .in_realtime =
         "this host did not keep time: panda-twin check measures how well it does and says "
         "what helps; close other programs, give the loops processors of their own "
         "(--ext-cpu, --int-cpu), or run in lockstep"},
    // 26 power_limit_violation
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "The motion took more power than the robot may give",
     .quantity = "power",
     .units = {"W"},
     .computed = "the sum over the joints of (tau_J_d + g(q)) dq, dq measured: what the drives put "
                 "into the "
                 "arm; what they take out of it counts against it",
     .cause =
         "large torques at high speed: a heavy load, hard acceleration of many joints at once, or "
         "pushing against something while moving",
     .cure = "move slower or accelerate less, carry less, and do not push while moving fast"},
    // 27 cartesian_motion_generator_joint_position_limits_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A Cartesian motion took a joint beyond its position limit",
     .quantity = "position",
     .units = {"rad"},
     .computed = "q_d of the inverse kinematics of the commanded pose and elbow",
     .cause = "the pose can only be reached beyond a joint's limit, with this elbow",
     .cure = kAwayFromSingular},
    // 28 cartesian_motion_generator_joint_velocity_limits_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A Cartesian motion took a joint faster than it may move",
     .quantity = "velocity",
     .units = {"rad/s"},
     .computed = "(q - q_d) / 1 ms, q of the inverse kinematics of the commanded pose and elbow",
     .cause = kSingular,
     .cure = kAwayFromSingular},
    // 29 cartesian_motion_generator_joint_velocity_discontinuity
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A Cartesian motion took a joint to an acceleration above its limit",
     .quantity = "acceleration",
     .units = {"rad/s^2"},
     .computed = "(dq - dq_d) / 1 ms, dq = (q - q_d) / 1 ms, q of the inverse kinematics of the "
                 "commanded pose and elbow",
     .cause = kSingular,
     .cure = kAwayFromSingular},
    // 30 cartesian_motion_generator_joint_acceleration_discontinuity
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A Cartesian motion took a joint to a jerk above its limit",
     .quantity = "jerk",
     .units = {"rad/s^3"},
     .computed = "(ddq - ddq_d) / 1 ms, ddq = (dq - dq_d) / 1 ms, dq = (q - q_d) / 1 ms, q of the "
                 "inverse kinematics of the commanded pose and elbow",
     .cause = kSingular,
     .cure = kAwayFromSingular},
    // 31 cartesian_position_motion_generator_invalid_frame_flag
    {.raised = true,
     .axis = AxisKind::kNone,
     .meaning = "The commanded pose was no rigid transform",
     .quantity = "deviation from a rotation",
     .units = {},
     .computed =
         "the largest deviation of O_T_EE_c from orthonormal, right-handed columns and a last "
         "row of (0, 0, 0, 1); not finite when the position is not",
     .cause =
         "the matrix is row-major instead of column-major, or a rotation that was multiplied on "
         "and on has lost its norm",
     .cure = "write poses column by column, and make rotations orthonormal again (by way of a unit "
             "quaternion) before they are sent"},
    // 32 controller_torque_discontinuity
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint's torque was commanded to change faster than it may",
     .quantity = "torque rate",
     .units = {"Nm/s"},
     .computed = "(tau_d - tau_J_d) / 1 ms, tau_J_d the last accepted torque",
     .cause = "a controller that starts with a step, has gains that amplify noise or a step of its "
              "target, or goes on after lost commands",
     .cure = "the torque may change by 1 Nm per cycle: begin at the state's tau_J_d, lower the "
             "controller's gains, or limit its rate",
     .in_scenario = "tick.limiter true limits it",
     .in_realtime = "tick.limiter true limits it"},
    // 33 joint_p2p_insufficient_torque_for_planning
    {.meaning = "A planned motion would overload a joint", .cause = kOwnMotion},
    // 34 tau_J_range_violation
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "A joint's torque sensor measured more than its range",
     .quantity = "measured torque",
     .units = {"Nm"},
     .computed = "tau_J of the state, gravity included",
     .cause = "the arm presses against something hard, carries too much, or was struck",
     .cure = "lower the torques or the load, or see what the arm ran into"},
    // 35 instability_detected
    {.raised = true,
     .axis = AxisKind::kJoint,
     .meaning = "The arm did not come to rest after a motion, and its brakes closed",
     .quantity = "measured velocity",
     .units = {"rad/s"},
     .computed = "dq of the state, of the fastest joint; with no motion running, some joint was as "
                 "fast in every 0.1 s of the last second",
     .cause = "the controller that holds the arm is not stable on it: a stiffness too high or a "
              "damping too low for the arm there is, a load that the robot is told of wrongly; or "
              "a person moves an arm that is held softly",
     .cure =
         "lower the stiffness (SetJointImpedance, SetCartesianImpedance), and tell the robot its "
         "load (SetLoad); the recovery opens the brakes",
     .in_scenario = kStableInRun,
     .in_realtime = kStableInRun},
    // 36 joint_move_in_wrong_direction
    {.meaning = "A joint that was beyond its limit was led further out",
     .cause = "it is raised while people lead the arm back from beyond a joint's limit, never by a "
              "motion"},
    // 37 cartesian_spline_motion_generator_violation
    {.meaning = "A planned Cartesian motion would violate a joint's limit", .cause = kOwnMotion},
    // 38 joint_via_motion_generator_planning_joint_limit_violation
    {.meaning = "A planned joint motion would violate a joint's limit", .cause = kOwnMotion},
    // 39 base_acceleration_initialization_timeout
    {.meaning = "The robot could not measure in time how its base is mounted",
     .cause =
         "it is raised while a robot starts; here gravity at the base is given, and known from the "
         "first cycle on"},
    // 40 base_acceleration_invalid_reading
    {.meaning = "The robot could not measure how its base is mounted",
     .cause = "it is raised by a sensor in the base; here gravity at the base is given"},
}};

const std::array<OtherCause, 2> kOtherCauses{
    {{RobotError::kCommunicationConstraintsViolation,
      kNoFirstCommandAxis,
      {.raised = true,
       .axis = AxisKind::kNone,
       .meaning = "The motion's first command did not come",
       .quantity = "cycles since the start of the motion",
       .units = {},
       .computed =
           "cycles since the state that first showed the motion, none of which had a command in "
           "time that answers the state before it",
       .cause =
           "the client ended, or waits for something else, between asking for the motion and its "
           "first command; or none of its commands arrives in time",
       .cure =
           "answer the states from the one on that shows the motion's modes; prepare what takes long "
           "before asking for the motion",
       .in_scenario =
           "a command counts only when state delay + tick.cost + command delay + link.d_INT "
           "stay below 1 ms: lower the delays or the losses; and the controller must deposit "
           "a first target (controller.phase, controller.cost)",
       .in_realtime =
           "panda-twin check measures how well this host keeps time, and says what helps"}},
     {RobotError::kInstabilityDetected,
      kNoNumberAxis,
      {.raised = true,
       .axis = AxisKind::kNone,
       .meaning = "What the robot measured or computed was no number, and its brakes closed",
       .quantity = "a measurement, a torque or a value of the state",
       .units = {},
       .computed =
           "q, dq, tau_J, theta and dtheta as the sensors give them, the torque before it is "
           "limited, and every value of the state",
       .cause = "the simulation of the arm's body broke down, and measures nothing any more",
       .cure =
           "see what was simulated: the summary says what the engine complained of; make masses, "
           "stiffnesses, forces and contacts those of a real arm"}}}};

}  // namespace twin
