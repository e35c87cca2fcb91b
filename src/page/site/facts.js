// Numbers, each with its explanation: lists that are updated in place, so that hover and focus stay.

import { explain } from "./tips.js";

// toFixed without the sign of a negative zero.
export function fixed(value, digits) {
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");
}

const degrees = (angle) => angle * 180 / Math.PI;

// A list in a dl. show() takes rows of [name, text, explanation, is bad]; the others disappear.
export function list(box) {
  const rows = new Map();
  let shown = "";

  function add(name, tip) {
    const row = document.createElement("div");
    const term = document.createElement("dt");
    const text = document.createElement("dd");
    term.textContent = name;
    row.append(term, text);
    explain(row, tip);
    rows.set(name, row);
  }
  return (all) => {
    for (const [name, , tip] of all) if (!rows.has(name)) add(name, tip);
    const names = all.map(([name]) => name);
    if (names.join() !== shown) {
      shown = names.join();
      for (const [name, row] of rows) row.hidden = !names.includes(name);
      box.append(...names.map((name) => rows.get(name)));
    }
    for (const [name, text, , bad = false] of all) {
      const value = rows.get(name).lastElementChild;
      if (value.textContent !== text) value.textContent = text;
      value.classList.toggle("bad", bad);
    }
  };
}

// Roll, pitch and yaw of O_T_EE (column-major): turns about x, then y, then z of the base, in degrees.
export function rollPitchYaw(T) {
  const roll = Math.atan2(T[6], T[10]);
  const pitch = Math.atan2(-T[2], Math.hypot(T[0], T[1]));
  const yaw = Math.atan2(T[1], T[0]);
  return [roll, pitch, yaw].map((angle) => {
    const turn = degrees(angle);
    return turn < -179.95 ? 180 : turn;  // one name for half a turn
  });
}

export function pose(T) {
  const turns = rollPitchYaw(T);
  return ["x", "y", "z"].map((axis, i) => [axis, `${fixed(T[12 + i], 3)} m`, `Position of the end effector along ${axis} of the base.`])
    .concat(["roll", "pitch", "yaw"].map((name, i) => [name, `${fixed(turns[i], 1)}\u00b0`,
      `Orientation of the end effector: turn about ${"xyz"[i]} of the base; about x first, then y, then z.`]));
}

function ofArm(arm) {
  const cycles = arm.served + arm.held;
  const all = [["force", `${Math.hypot(...arm.F.slice(0, 3)).toFixed(1)} N`,
    "External force on the arm, as the robot estimates it from its joint torques (O_F_ext_hat_K)."]];
  if (arm.margin !== null) {
    all.push(["room to brake", `${(100 * arm.margin).toFixed(1)} %`,
      "Smallest distance of a joint's reference from where no later command could keep its position and speed limits, even if the "
        + "next commands are lost; share of the limit. 0 %: at the border.", arm.margin < 0.02]);
  }
  all.push(["lost cycles", cycles ? `${(100 * arm.held / cycles).toFixed(2)} %` : "none yet",
    "Cycles of 1 ms in which no command reached the robot in time, so that it went on by itself; share of all cycles of motions."]);
  return all;
}

function ofBase(base) {
  return [["base", base.mode, "What the mobile base does.", base.mode === "emergency stop"],
    ["speed", `${fixed(base.v, 2)} m/s  ${fixed(base.w, 2)} rad/s`, "Of the base: ahead, and turning to the left."],
    ["odometry", `${fixed(base.x, 2)}  ${fixed(base.y, 2)} m  ${fixed(degrees(base.yaw), 0)}\u00b0`,
      "Where the base believes it is since the start, by its wheels: ahead, left, turned."]];
}

// The rows of the list of numbers. answers: of the page's server, and of the robot to input, in ms; null: unknown.
export function facts({ arm, base, hand, teleop, clients }, answers) {
  const all = arm ? ofArm(arm) : [];
  if (base) all.push(...ofBase(base));
  if (hand) {
    const sucks = hand.vacuum !== null;
    all.push(["hand", `${sucks ? `${hand.vacuum} mbar` : `${(1000 * hand.width).toFixed(0)} mm`}${hand.is_grasped ? ", holds" : ""}`,
      `${sucks ? "Vacuum in the cups" : "Opening between the fingers"}, and whether something is held.`]);
  }
  if (teleop) {
    all.push(["moves", teleop.stopped ? "stopped" : teleop.holding ? `${teleop.mode}, holds` : teleop.mode,
      "The part that the sticks move. Holds: no input reaches it.", teleop.stopped || teleop.holding]);
  }
  if (answers.robot !== null) {
    all.push(["robot answers in", `${answers.robot.toFixed(0)} ms`, "From your input to the robot and back to this page, all delays included."]);
  }
  if (answers.page !== null) {
    all.push(["page answers in", `${answers.page.toFixed(0)} ms`, "From this browser to panda-twin and back, without the robot."]);
  }
  all.push(["pages", String(clients), "Browsers that show this robot, yours included."]);
  return all;
}
