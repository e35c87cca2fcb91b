// The operator's page: one WebSocket, whose messages src/page/README.md lists.
import { facts, fixed, list, pose } from "./facts.js";
import { joints } from "./jog.js";
import { curves, jointBars, roomOf, triad } from "./plots.js";
import { replays } from "./replay.js";
import { isLed, isStopped, mayResume, verdict } from "./status.js";
import { hands as makeHands } from "./sticks.js";
import { explain } from "./tips.js";
import { views as makeViews } from "./views.js";

const $ = (id) => document.getElementById(id);
const HANDS_MS = 33;
const REFUSAL_MS = 8000;
const JOINTS = ["1", "2", "3", "4", "5", "6", "7"];
const AXES = ["x", "y", "z"];

let socket = null;
let me = 0;
let welcome = null;
let state = null;  // the newest
let advanced = 0;  // performance.now() when the robot's time went on last
const STANDS_MS = 500;  // longer than any hold-up of a busy machine that is not worth telling
let displayed = null;  // the same, or that of the replay
let over = null;  // how the run ended
let lost = "The page connects to panda-twin.";  // why there is no connection; null: there is
let refusal = null;  // the last one: its text, and until when it is shown
let showBars = () => {};
let clutched = false;
let recording = false;
let pageAnswers = null;

const operates = () => me !== 0 && !over && state !== null && state.operator === me;
const replay = replays({ replay: $("replay"), play: $("play"), moment: $("moment"), ago: $("ago") }, { show: showAgain, changed: showStatus });
const leadsNow = () => operates() && isLed(state) && !isStopped(state) && !state.paused && !replay.isOn();
const jog = joints($("jog"), leadsNow);
const hands = makeHands([$("left"), $("right"), $("tilt")], () => leadsNow() && !jog.isOn());
const views = makeViews(say, replay);
const showPose = list($("pose"));
const showFacts = list($("facts"));

const largest = (digits, unit) => (values) => `${fixed(Math.max(...values.map(Math.abs)), digits)} ${unit}`;
const length = (unit) => (values) => `${Math.hypot(...values).toFixed(1)} ${unit}`;
const plot = (options) => curves($("plots"), { none: "none", ...options });
const plots = {
  room: plot({ title: "Joint margin", unit: "\u00b0", names: JOINTS, upTo: 60, now: (values) => `${fixed(Math.min(...values), 0)}\u00b0`,
    tip: "Distance of each joint to its nearer limit, up to 60\u00b0; the number is the smallest." }),
  error: plot({ title: "Tracking error", unit: "mrad", names: JOINTS, least: 1, now: largest(1, "mrad"), none: "torque control",
    tip: "Reference minus measured angle of each joint, q_d - q; the number is the largest. Under torque control the robot has no reference." }),
  speeds: plot({ title: "Joint speed", unit: "% of the limit", names: JOINTS, least: 5, now: largest(0, "%"),
    tip: "Speed of each joint as a share of its limit; the number is the largest." }),
  forces: plot({ title: "External force", unit: "N", names: AXES, least: 5, now: length("N"),
    tip: "Force on the arm along the axes of the base, as the robot estimates it; the number is its magnitude." }),
  torques: plot({ title: "External torque", unit: "Nm", names: AXES, least: 1, now: length("Nm"),
    tip: "Torque on the arm about the axes of the base, as the robot estimates it; the number is its magnitude." }),
};

// ---- connection

function say(type, more = {}) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ type, ...more }));
}

function connect(token) {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.binaryType = "blob";
  socket.onopen = () => say("hello", views.hello(token));
  socket.onmessage = (event) => typeof event.data === "string" ? hear(JSON.parse(event.data)) : views.picture(event.data);
  socket.onclose = (event) => {
    me = 0;
    letGo();
    lost = `The connection is gone${event.reason ? `: ${event.reason}` : ""}. Trying again.`;
    if (event.reason === "wrong token") {
      sessionStorage.removeItem("token");
      askToken("That is not the token this run has printed.");
    } else if (!over) {
      setTimeout(() => connect(token), 1500);
    }
    showStatus();
  };
}

function hear(message) {
  switch (message.type) {
    case "welcome": begin(message); break;
    case "state": show(message); break;
    case "poses": views.poses(message); break;
    case "event": tellEvent(message); break;
    case "refused": refusal = { text: message.text, until: performance.now() + REFUSAL_MS }; break;
    case "pong": pageAnswers = performance.now() - message.sent_ms; break;
    case "end":
      over = message;
      letGo();
      showStatus();
      break;
    default: break;
  }
}

function begin(message) {
  welcome = message;
  me = message.you;
  lost = null;
  $("title").textContent = message.title;
  $("about").textContent = message.about;
  $("hands").hidden = message.watch_only !== "";
  $("record").hidden = !message.may_record;
  views.begin(message);
  $("bars").replaceChildren();
  $("events").replaceChildren();
  showBars = jointBars($("bars"), message.limits);
  const whyNot = message.no_pause ? ` Not here: ${message.no_pause}.` : "";
  explain($("pause"), `Lets the run's clock stand, and go on. Key P.${whyNot}`);
  $("pause").setAttribute("aria-disabled", String(whyNot !== ""));
}

// ---- display

function setText(id, text) {
  if ($(id).textContent !== text) $(id).textContent = text;
}

function showStatus() {
  const told = verdict({ over, lost, welcome, state, operates: operates(), stands: performance.now() - advanced > STANDS_MS });
  const refused = refusal && performance.now() < refusal.until ? `Refused: ${refusal.text}. ` : "";
  setText("word", told.word);
  setText("leads", replay.isOn() ? "You watch a replay. This line is live." : told.leads);
  setText("why", refused + told.why);
  $("status").dataset.tone = told.tone;
  document.body.dataset.tone = told.tone;
  document.title = `${told.word} \u2013 ${welcome ? welcome.title : "panda-twin"}`;
  $("stopped").hidden = told.tone !== "stop" || replay.isOn();
  $("replayed").hidden = !document.body.classList.toggle("replaying", replay.isOn());
  if (document.body.classList.toggle("operating", leadsNow()) === false) letGo();
  document.body.classList.toggle("limited", Boolean(state && state.teleop && state.teleop.at_border));
  if (clutched && !leadsNow()) clutch(false);
  showReport();
  if (state) showButtons(operates(), state);
}

// A browser opens no file from a page that came over HTTP: the page names its path.
function showReport() {
  $("pause").hidden = Boolean(over);
  const path = over && welcome ? welcome.report : "";
  $("report").hidden = !path;
  $("copy").hidden = !path || !navigator.clipboard;
  if (path) setText("report", `Its report, once it is written: ${path}`);
}

function showButtons(mine, { arm, base, session, teleop }) {
  $("take").hidden = me === 0 || Boolean(over) || welcome.watch_only !== "";
  setText("take", mine ? "Give back" : "Take control");
  $("take").classList.toggle("main", !mine);
  for (const id of ["mode", "gripper", "frame", "scale", "clutch", "joints"]) $(id).disabled = !leadsNow();
  setText("pause", state.paused ? "Resume" : "Pause");
  $("pause").setAttribute("aria-pressed", String(state.paused));
  if (teleop && teleop.mode === "base" && jog.isOn()) turnJoints(false);
  for (const id of ["record", "end"]) $(id).disabled = !mine || !isLed(state);
  $("release").hidden = !mine || !isStopped(state);
  $("recover").hidden = !welcome.may_resume || !mayResume(state, mine);
  setText("recover", arm && arm.mode === "Idle" ? "Lead on" : "Recover");
  $("home").hidden = !welcome.may_resume || !mine || isStopped(state) || !["rests", "leads"].includes(session);
  $("mode").hidden = !base;
  if (teleop) {
    $("mode").firstChild.textContent = teleop.mode === "base" ? "Lead the arm " : "Lead the base ";
    $("scale").setAttribute("aria-pressed", String(teleop.fine));
    $("gripper").firstChild.textContent = teleop.hand_closed ? "Open hand " : "Close hand ";
  }
}

function show(message) {
  const before = state;
  if (message.t !== state?.t) advanced = performance.now();
  state = message;
  replay.keep("state", message);
  showStatus();
  views.state(message);
  if (!replay.isOn()) display(message);
  const arm = state.arm;
  if (!arm || (before && before.arm && before.arm.t === arm.t)) return;
  plots.room.add(arm.t, roomOf(arm.q, welcome.limits));
  plots.error.add(arm.t, arm.error && arm.error.map((value) => 1000 * value));
  plots.speeds.add(arm.t, arm.dq.map((value, i) => 100 * value / welcome.limits.dq_max[i]));
  plots.forces.add(arm.t, arm.F.slice(0, 3));
  plots.torques.add(arm.t, arm.F.slice(3));
}

// What the replay shows; the plots and the line of state stay live.
function showAgain({ state: old, picture, poses }) {
  if (old) display(old);
  views.again({ tool: displayed.arm && displayed.arm.O_T_EE, picture, poses });
}

function display(state) {
  displayed = state;
  setText("clock", `${state.t.toFixed(1)} s`);
  const robot = operates() && !replay.isOn() && state.teleop && state.teleop.echo_ms !== null ? performance.now() - state.teleop.echo_ms : null;
  showFacts(facts(state, { robot, page: pageAnswers }));
  if (!state.arm) return;
  showPose(pose(state.arm.O_T_EE));
  showBars(state.arm.q);
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
  for (const each of Object.values(plots)) each.draw(replay.time());
  if (displayed && displayed.arm) triad($("triad"), displayed.arm.O_T_EE);
  const rate = views.rate();
  $("rate").hidden = rate === null;
  if (rate !== null) setText("rate", `${rate.toFixed(0)} pictures/s`);
}, 150);
setInterval(() => say("ping", { sent_ms: performance.now() }), 1000);

// ---- operator input

const speed = () => Number($("speed").value) / 100;
const drives = () => Boolean(state && state.teleop && state.teleop.mode === "base");

setInterval(() => {
  if (!operates() || document.hidden) return;
  const input = jog.isOn() ? jog.input(speed()) : { axes: hands.axes(speed(), drives()) };
  say("hands", { ...input, engaged: !clutched, sent_ms: performance.now() });
}, HANDS_MS);

function letGo() {
  hands.letGo();
  jog.letGo();
}

function turnJoints(on) {
  jog.turn(on);
  hands.letGo();
  $("joints").setAttribute("aria-pressed", String(on));
  $("jog").hidden = !on;
  document.querySelector(".sticks").hidden = on;
}

function clutch(on) {
  clutched = on && leadsNow();
  $("clutch").setAttribute("aria-pressed", String(clutched));
}

function stop() {
  letGo();
  replay.live();
  say("stop");
}

function faster(steps) {
  $("speed").value = Number($("speed").value) + steps * Number($("speed").step);
  setText("speed-told", `${$("speed").value} %`);
}

$("take").onclick = () => say(operates() ? "give_back" : "take");
for (const id of ["mode", "gripper", "frame", "scale", "release", "end"]) $(id).onclick = () => say("press", { button: id });
for (const id of ["recover", "home"]) $(id).onclick = () => say(id);
$("pause").onclick = () => say("pause", { on: !(state && state.paused) });
$("joints").onclick = () => turnJoints(!jog.isOn());
$("copy").onclick = () => navigator.clipboard.writeText(welcome.report);
$("record").onclick = () => say("record", { on: !recording });
$("speed").oninput = () => faster(0);
// On pressing the button, not on its release.
$("stop").addEventListener("pointerdown", stop);
$("stop").addEventListener("keydown", (event) => { if (event.code === "Enter") stop(); });
$("clutch").addEventListener("pointerdown", (event) => { $("clutch").setPointerCapture(event.pointerId); clutch(true); });
for (const kind of ["pointerup", "pointercancel"]) $("clutch").addEventListener(kind, () => clutch(false));

// Keys control the robot whichever element has the focus, except text fields.
const writes = (event) => event.target.closest("#ask");
for (const id of ["cameras", "speed"]) $(id).addEventListener("change", () => $(id).blur());

const PRESSES = { KeyM: "mode", KeyG: "gripper", KeyX: "frame", KeyV: "scale" };
const FASTER = { Minus: -1, NumpadSubtract: -1, Equal: 1, NumpadAdd: 1 };
window.addEventListener("keydown", (event) => {
  if (event.code === "Escape" || (event.code === "Space" && !writes(event))) {
    event.preventDefault();
    if (!event.repeat) stop();
    return;
  }
  if (event.ctrlKey || event.altKey || event.metaKey || writes(event)) return;
  if (event.code in FASTER) faster(FASTER[event.code]);
  if (event.repeat) return;
  if (event.code in PRESSES && leadsNow()) say("press", { button: PRESSES[event.code] });
  if (event.code === "KeyC") clutch(true);
  if (event.code === "KeyJ" && leadsNow() && !drives()) turnJoints(!jog.isOn());
  if (event.code === "KeyP") $("pause").click();
  if (event.code === "KeyB") replay.toggle();
}, true);
window.addEventListener("keyup", (event) => {
  if (event.code === "KeyC") clutch(false);
  if (event.code === "Space" && !writes(event)) event.preventDefault();
}, true);
window.addEventListener("blur", () => clutch(false));

// ---- start

function askToken(why) {
  lost = why;
  $("ask").hidden = false;
  $("token").focus();
}

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
else askToken("This page needs the token that panda-twin printed.");
showStatus();
