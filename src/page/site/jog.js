// Turning one joint at a time: a button for each joint and direction, or the arrow keys.

const TURNS = { ArrowLeft: -1, ArrowRight: 1 };
const CHOOSES = { ArrowUp: -1, ArrowDown: 1 };
const COUNT = 7;

// Fills `box`. Nothing turns while mayMove() is false.
export function joints(box, mayMove) {
  let isOn = false;
  let joint = 1;
  let held = null;  // what turns the joint: its way, and the button or key that began it

  const rows = Array.from({ length: COUNT }, (_, i) => {
    const row = document.createElement("div");
    row.className = "joint";
    const name = document.createElement("span");
    name.textContent = `J${i + 1}`;
    row.append(button(i + 1, -1), name, button(i + 1, 1));
    box.lastElementChild.before(row);
    return row;
  });
  choose(1);

  function button(number, way) {
    const element = document.createElement("button");
    element.textContent = way > 0 ? "+" : "\u2212";
    element.setAttribute("aria-label", `Turn joint ${number} ${way > 0 ? "forward" : "back"} while held`);
    element.addEventListener("pointerdown", (event) => {
      if (!hold(number, way, element)) return;
      element.setPointerCapture(event.pointerId);
      event.preventDefault();
    });
    for (const kind of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) element.addEventListener(kind, () => release(element));
    element.addEventListener("keydown", (event) => { if (event.code === "Enter" && !event.repeat) hold(number, way, element); });
    element.addEventListener("keyup", (event) => { if (event.code === "Enter") release(element); });
    return element;
  }

  function choose(number) {
    joint = number;
    rows.forEach((row, i) => row.classList.toggle("chosen", i + 1 === joint));
  }
  function hold(number, way, by) {
    if (!isOn || !mayMove()) return false;
    choose(number);
    held = { way, by };
    show();
    return true;
  }
  function release(by) {
    if (held && held.by === by) letGo();
  }
  function letGo() {
    held = null;
    show();
  }
  function show() {
    rows.forEach((row, i) => {
      const way = held && i + 1 === joint ? held.way : 0;
      row.firstElementChild.classList.toggle("held", way < 0);
      row.lastElementChild.classList.toggle("held", way > 0);
    });
  }

  window.addEventListener("keydown", (event) => {
    if (!isOn || event.ctrlKey || event.altKey || event.metaKey || event.target.closest("#ask, select, input")) return;
    if (!(event.code in TURNS) && !(event.code in CHOOSES)) return;
    event.preventDefault();
    if (event.code in TURNS && !event.repeat) hold(joint, TURNS[event.code], event.code);
    if (event.code in CHOOSES && !held) choose((joint - 1 + CHOOSES[event.code] + COUNT) % COUNT + 1);
  });
  window.addEventListener("keyup", (event) => release(event.code));
  window.addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", () => { if (document.hidden) letGo(); });

  return {
    letGo,
    isOn: () => isOn,
    turn(on) {
      isOn = on;
      letGo();
    },
    // Of the message `hands`.
    input: (speed) => ({ joint, axes: [held ? held.way * speed : 0, 0, 0, 0, 0, 0] }),
  };
}
