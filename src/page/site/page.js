// The operator's page: one WebSocket, whose messages src/page/README.md lists.
import { hands as makeHands } from "./sticks.js";
import { curves, fixed, jointBars } from "./plots.js";

const $ = (id) => document.getElementById(id);
const HANDS_MS = 33;

let socket = null;
let me = 0;
let welcome = null;
let state = null;
let showBars = () => {};
let over = false;
let clutched = false;
let recording = false;
let pictures = [];
let turnaround = null;

const hands = makeHands($("left"), $("right"), $("tilt"));
const speeds = curves($("speeds"), ["1", "2", "3", "4", "5", "6", "7"], 5);
const forces = curves($("forces"), ["x", "y", "z"], 5);
const torques = curves($("torques"), ["x", "y", "z"], 1);

// ---- connection

function say(type, more = {}) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ type, ...more }));
}

function notice(text) {
  $("notice").hidden = !text;
  $("notice").textContent = text;
}

function connect(token) {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.binaryType = "blob";
  socket.onopen = () => say("hello", { token });
  socket.onmessage = (event) => typeof event.data === "string" ? hear(JSON.parse(event.data)) : look(event.data);
  socket.onclose = (event) => {
    document.body.classList.remove("operating");
    me = 0;
    if (event.reason === "wrong token") {
      sessionStorage.removeItem("token");
      $("ask").hidden = false;
    } else if (!over) {
      notice(`The connection is gone${event.reason ? `: ${event.reason}` : ""}. Trying again.`);
      setTimeout(() => connect(token), 1500);
    }
    showRole();
  };
}

function hear(message) {
  switch (message.type) {
    case "welcome": begin(message); break;
    case "state": show(message); break;
    case "event": tellEvent(message); break;
    case "refused": notice(message.text); break;
    case "pong": turnaround = performance.now() - message.sent_ms; break;
    case "end":
      over = true;
      notice(`The run is over: ${message.text}`);
      break;
    default: break;
  }
}

function begin(message) {
  welcome = message;
  me = message.you;
  notice(message.watch_only);
  $("title").textContent = message.title;
  $("about").textContent = message.about;
  $("hands").hidden = message.watch_only !== "";
  document.body.classList.toggle("watches", message.watch_only !== "");
  $("record").hidden = !message.may_record;
  $("cameras").replaceChildren(...message.cameras.map((name) => new Option(name)));
  $("bars").replaceChildren();
  $("events").replaceChildren();
  showBars = jointBars($("bars"), message.limits);
}

async function look(data) {
  const picture = await createImageBitmap(data);
  const canvas = $("camera");
  if (canvas.width !== picture.width || canvas.height !== picture.height) {
    canvas.width = picture.width;
    canvas.height = picture.height;
  }
  canvas.getContext("2d").drawImage(picture, 0, 0);
  picture.close();
  $("no-picture").hidden = true;
  say("shown");
  const now = performance.now();
  pictures.push(now);
  pictures = pictures.filter((at) => at > now - 2000);
}

// ---- display

const operating = () => me !== 0 && state !== null && state.operator === me;

function showRole() {
  const badge = $("role");
  badge.className = `badge${me === 0 ? " lost" : operating() ? " operates" : ""}`;
  if (me === 0) badge.textContent = over ? "over" : "no connection";
  else if (operating()) badge.textContent = "you operate";
  else badge.textContent = state && state.operator ? `watching; ${state.operator} operates` : "watching";
  document.body.classList.toggle("operating", operating());
}

function showButtons() {
  const teleop = state.teleop;
  $("take").disabled = over;
  $("take").textContent = operating() ? "Give back" : "Take control";
  for (const id of ["mode", "gripper", "frame", "scale", "clutch", "release", "record", "end"]) $(id).disabled = over || !operating();
  $("release").hidden = !((teleop && teleop.stopped) || (state.arm && state.arm.mode === "User stopped"));
  if (teleop) {
    $("mode").firstChild.textContent = teleop.mode === "base" ? "Lead the arm " : "Lead the base ";
    $("scale").setAttribute("aria-pressed", String(teleop.fine));
    $("gripper").firstChild.textContent = teleop.hand_closed ? "Open hand " : "Close hand ";
  }
}

function fact(name, value, bad = false) {
  const term = document.createElement("dt");
  const text = document.createElement("dd");
  term.textContent = name;
  text.textContent = value;
  text.classList.toggle("bad", bad);
  return [term, text];
}

function facts() {
  const { arm, base, hand, teleop } = state;
  const all = [["time", `${state.t.toFixed(1)} s`]];
  if (arm) {
    const cycles = arm.served + arm.held;
    all.push(["robot", arm.mode, arm.mode !== "Move" && arm.mode !== "Idle"]);
    if (arm.margin !== null) all.push(["margin", `${(100 * arm.margin).toFixed(1)} %`, arm.margin < 0.02]);
    all.push(["end effector", `${arm.p.map((v) => fixed(v, 2)).join("  ")} m`]);
    all.push(["force", `${Math.hypot(...arm.F.slice(0, 3)).toFixed(1)} N`]);
    all.push(["unserved", cycles ? `${(100 * arm.held / cycles).toFixed(2)} %` : "none yet"]);
  }
  if (base) {
    all.push(["base", base.mode, base.mode === "emergency stop"]);
    all.push(["speed", `${fixed(base.v, 2)} m/s  ${fixed(base.w, 2)} rad/s`]);
    all.push(["odometry", `${fixed(base.x, 2)}  ${fixed(base.y, 2)} m  ${fixed(base.yaw * 180 / Math.PI, 0)}\u00b0`]);
  }
  if (hand) all.push(["hand", `${(1000 * hand.width).toFixed(0)} mm${hand.is_grasped ? ", holds something" : ""}`]);
  if (teleop) {
    if (teleop.at_border) all.push(["border", "no further that way", true]);
    all.push(["moves", teleop.stopped ? "stopped" : teleop.holding ? `${teleop.mode}, holds` : teleop.mode, teleop.stopped || teleop.holding]);
    if (operating() && teleop.echo_ms !== null) all.push(["robot, there and back", `${(performance.now() - teleop.echo_ms).toFixed(0)} ms`]);
  }
  if (turnaround !== null) all.push(["page, there and back", `${turnaround.toFixed(0)} ms`]);
  all.push(["clients", String(state.clients)]);
  return all;
}

function showErrors(arm) {
  const texts = !arm ? [] : arm.errors.map((name) => `error: ${name}`)
    .concat(arm.errors.length ? [] : arm.reflex.map((name) => `the last motion ended by ${name}`));
  $("errors").replaceChildren(...texts.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
}

function show(message) {
  const before = state;
  state = message;
  showRole();
  showButtons();
  $("facts").replaceChildren(...facts().flatMap((entry) => fact(...entry)));
  $("cameras").selectedIndex = state.camera;
  if (state.no_picture) {
    $("no-picture").hidden = false;
    $("no-picture").textContent = state.no_picture;
  }
  const arm = state.arm;
  showErrors(arm);
  if (!arm || (before && before.arm && before.arm.t === arm.t)) return;
  showBars(arm.q);
  speeds.add(arm.t, arm.dq.map((value, i) => 100 * value / welcome.limits.dq_max[i]));
  forces.add(arm.t, arm.F.slice(0, 3));
  torques.add(arm.t, arm.F.slice(3));
}

function tellEvent({ t, kind, text }) {
  const item = document.createElement("li");
  for (const part of [`${t.toFixed(1)} s`, kind]) {
    const span = document.createElement("span");
    span.textContent = part;
    item.append(span);
  }
  item.append(text);
  $("events").prepend(item);
  while ($("events").children.length > 60) $("events").lastElementChild.remove();
  if (kind === "record") {
    recording = text.startsWith("recording");
    $("record").setAttribute("aria-pressed", String(recording));
  }
}

setInterval(() => {
  for (const plot of [speeds, forces, torques]) plot.draw();
  $("rate").textContent = pictures.length ? `${(pictures.length / 2).toFixed(0)} pictures/s` : "";
}, 150);
setInterval(() => say("ping", { sent_ms: performance.now() }), 1000);

// ---- operator input

const speed = () => Number($("speed").value) / 100;
const drives = () => state && state.teleop && state.teleop.mode === "base";

setInterval(() => {
  if (!operating() || document.hidden) return;
  say("hands", { axes: hands.axes(speed(), drives()), engaged: !clutched, sent_ms: performance.now() });
}, HANDS_MS);

function clutch(on) {
  clutched = on && operating();
  $("clutch").setAttribute("aria-pressed", String(clutched));
}

function stop() {
  hands.letGo();
  say("stop");
}

$("take").onclick = () => say(operating() ? "give_back" : "take");
for (const id of ["mode", "gripper", "frame", "scale", "release", "end"]) $(id).onclick = () => say("press", { button: id });
$("record").onclick = () => say("record", { on: !recording });
$("cameras").onchange = () => say("camera", { number: $("cameras").selectedIndex });
$("speed").oninput = () => { $("speed-told").textContent = `${$("speed").value} %`; };
// On pressing the button, not on its release.
$("stop").addEventListener("pointerdown", stop);
$("stop").addEventListener("keydown", (event) => { if (event.code === "Enter") stop(); });
$("clutch").addEventListener("pointerdown", (event) => { $("clutch").setPointerCapture(event.pointerId); clutch(true); });
for (const kind of ["pointerup", "pointercancel"]) $("clutch").addEventListener(kind, () => clutch(false));

// Keys control the robot whichever element has the focus, except text fields.
const writes = (event) => event.target.closest("#ask");
for (const id of ["cameras", "speed"]) $(id).addEventListener("change", () => $(id).blur());

const PRESSES = { KeyM: "mode", KeyG: "gripper", KeyX: "frame", KeyV: "scale" };
window.addEventListener("keydown", (event) => {
  if (event.code === "Escape" || (event.code === "Space" && !writes(event))) {
    event.preventDefault();
    if (!event.repeat) stop();
    return;
  }
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey || writes(event)) return;
  if (event.code in PRESSES && operating()) say("press", { button: PRESSES[event.code] });
  if (event.code === "KeyC") clutch(true);
}, true);
window.addEventListener("keyup", (event) => {
  if (event.code === "KeyC") clutch(false);
  if (event.code === "Space" && !writes(event)) event.preventDefault();
}, true);
window.addEventListener("blur", () => clutch(false));

// ---- start

$("ask").onsubmit = (event) => {
  event.preventDefault();
  $("ask").hidden = true;
  sessionStorage.setItem("token", $("token").value.trim());
  connect($("token").value.trim());
};
const given = new URLSearchParams(location.hash.slice(1)).get("token");
if (given) {
  sessionStorage.setItem("token", given);
  history.replaceState(null, "", location.pathname);  // hides the token from the address bar and the history
}
const token = sessionStorage.getItem("token");
if (token) connect(token);
else $("ask").hidden = false;
