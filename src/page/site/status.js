// What the page says about the robot in one place: a word and its tone, who leads, and why it does not move.

const MODES = {
  "Idle": ["idle", "The robot stands and waits for a motion."],
  "Move": ["good", "A motion is under way; it may stand still."],
  "Guiding": ["good", "A person guides the arm by hand."],
  "Reflex": ["bad", "The robot stopped by itself."],
  "User stopped": ["stop", "The user stop is pressed."],
  "Automatic error recovery": ["warn", "The robot clears its error."],
  "Other": ["warn", "The robot is not ready."],
};

// Whether STOP holds the robot.
export function isStopped(state) {
  if (!state) return false;
  return Boolean(state.teleop && state.teleop.stopped) || Boolean(state.arm && state.arm.mode === "User stopped")
    || Boolean(state.base && state.base.mode === "emergency stop");
}

// Whether input reaches the robot: a session leads it, and its motion has begun. A run without sessions leads it all the time.
export const isLed = ({ session, arm }) => session === null || (session === "leads" && arm !== null && arm.mode === "Move");

// Whether the operator may begin anew: no session, nothing is stopped, and the robot can.
export function mayResume(state, operates) {
  return operates && state.session === "rests" && !isStopped(state) && Boolean(state.arm) && ["Idle", "Reflex"].includes(state.arm.mode);
}

function leadsWhat(teleop) {
  return teleop?.joint ? `You lead joint ${teleop.joint}.` : `You lead the ${teleop?.mode ?? "arm"}.`;
}

function leads({ welcome, state, operates }) {
  if (welcome.watch_only) return "Its own program leads it.";
  if (operates && state.session === "goes home") return "You have sent it home.";
  if (operates) return isLed(state) && !isStopped(state) ? leadsWhat(state.teleop) : "You have control.";
  if (state.operator) return `Connection ${state.operator} leads.`;
  return state.arm?.mode === "Move" && !state.teleop ? "A program leads it." : "No operator.";
}

const sentence = (text) => (text ? `${text[0].toUpperCase()}${text.slice(1)}.` : "");

function errorsOf(arm) {
  if (arm.errors.length) return `Error: ${arm.errors.join(", ")}.`;
  return arm.reflex.length ? `The last motion ended by ${arm.reflex.join(", ")}.` : "";
}

function stopped({ welcome, state, operates }) {
  let cure = "Take control to release it.";
  if (state.operator) cure = "The page that leads the robot can release it.";
  if (operates) cure = "Release stop lets the robot move again.";
  if (welcome.watch_only) cure = "It is not released from here.";
  return { word: "Stopped", tone: "stop", why: `The stop is pressed, and the robot holds. ${cure}` };
}

function ofMode({ welcome, state, operates, stands }) {
  const { arm, teleop } = state;
  const [tone, meaning] = MODES[arm.mode] ?? ["warn", ""];
  const told = { word: arm.mode, tone, why: errorsOf(arm) || sentence(welcome.watch_only) || meaning };
  if (state.paused) return { ...told, word: "Paused", tone: "warn", why: "The run's clock stands. Resume lets it go on; STOP does too, and stops the robot." };
  if (stands && arm.mode === "Move") return { ...told, word: "Waits", tone: "warn", why: "The robot's time stands: it waits for the answer of the program that moves it." };
  if (state.session === "goes home") return { ...told, why: "The arm moves to its start by a planned way. STOP ends it." };
  if (state.session === "connects" || (state.session === "leads" && !isLed(state))) return { ...told, why: `${told.why} The operator's session begins.` };
  if (mayResume(state, operates)) {
    told.why = `${told.why} ${arm.mode === "Reflex" ? "Recover" : "Lead on"} lets you lead it on.`;
  } else if (arm.mode === "Move" && operates && teleop) {
    if (teleop.at_border) return { ...told, tone: "warn", why: `No further that way: ${teleop.why}.` };
    if (teleop.awaits_release) return { ...told, tone: "warn", why: "Let go of all keys and sticks; then they lead again." };
    if (teleop.holding) return { ...told, tone: "warn", word: "Holds", why: "No input reaches the robot." };
  } else if (arm.mode === "Move" && teleop && teleop.holding) {
    return { ...told, word: "Holds", why: "The robot holds its place: there is no operator." };
  }
  return told;
}

// now: over (how the run ended, or null), lost (why there is no connection, or null), welcome and state (null before the first),
// operates, stands (the robot's time has not gone on for a while). @returns word, tone (good, idle, warn, bad, stop), leads, why.
export function verdict(now) {
  if (now.over) return { word: "Over", tone: now.over.is_failure ? "bad" : "good", leads: "", why: `${now.over.is_failure ? "The run failed" : "The run is over"}: ${now.over.text}.` };
  if (now.lost !== null) return { word: "No connection", tone: "warn", leads: "", why: now.lost };
  const { state } = now;
  if (!state || !state.arm) return { word: "Waiting", tone: "idle", leads: "", why: sentence(now.welcome.watch_only) || "The robot has sent no state yet." };
  return { leads: leads(now), ...(isStopped(state) ? stopped(now) : ofMode(now)) };
}
