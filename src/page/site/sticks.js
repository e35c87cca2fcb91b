// The operator's input: three sticks by touch or mouse, and keys. The sticks show both.

const KEYS = {
  KeyW: [0, 1], KeyS: [0, -1], KeyA: [1, 1], KeyD: [1, -1], KeyR: [2, 1], KeyF: [2, -1],
  ArrowRight: [3, 1], ArrowLeft: [3, -1], ArrowUp: [4, 1], ArrowDown: [4, -1], KeyQ: [5, 1], KeyE: [5, -1],
};

// A stick in `element`, which `changed` is told of; value() is [to the right, up], each in [-1, 1].
function stick(element, mayMove, changed) {
  const knob = element.firstElementChild;
  let holder = null;
  let value = [0, 0];

  function set(x, y) {
    const length = Math.max(1, Math.hypot(x, y));
    value = [x / length, y / length];
    changed();
  }
  function follow(event) {
    if (event.pointerId !== holder) return;
    const box = element.getBoundingClientRect();
    set((event.clientX - box.left) / box.width * 2.6 - 1.3, 1.3 - (event.clientY - box.top) / box.height * 2.6);
  }
  function letGo(event) {
    if (event && event.pointerId !== holder) return;
    holder = null;
    set(0, 0);
  }
  element.addEventListener("pointerdown", (event) => {
    if (holder !== null || !mayMove()) return;
    holder = event.pointerId;
    element.setPointerCapture(holder);
    follow(event);
    event.preventDefault();
  });
  element.addEventListener("pointermove", follow);
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) element.addEventListener(kind, letGo);

  // The knob where a stick with these deflections stands.
  function show(x, y) {
    const length = Math.max(1, Math.hypot(x, y));
    knob.style.transform = `translate(${x / length * 85}%, ${-y / length * 85}%)`;
  }
  return { value: () => value, letGo, show };
}

const inOne = (value) => Math.max(-1, Math.min(1, value));

// axes(speed, drives): x, y, z, about x, y, z: forward, left, up for the operator. A base drives forward and turns;
// it cannot move left, so the left stick turns it. Nothing moves while mayMove() is false.
export function hands(elements, mayMove) {
  const held = new Set();
  const sticks = elements.map((element) => stick(element, mayMove, () => show()));

  function deflections() {
    const [a, b, c] = sticks.map((each) => each.value());
    const all = [a[1], -a[0], b[1], c[0], c[1], -b[0]];
    for (const code of held) all[KEYS[code][0]] += KEYS[code][1];
    return all.map(inOne);
  }
  function show() {
    if (sticks.length < elements.length) return;
    const [x, y, z, aboutX, aboutY, aboutZ] = deflections();
    sticks[0].show(-y, x);
    sticks[1].show(-aboutZ, z);
    sticks[2].show(aboutX, aboutY);
  }
  function letGo() {
    held.clear();
    for (const each of sticks) each.letGo();
  }

  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || !(event.code in KEYS) || !mayMove() || event.target.closest("#ask")) return;
    event.preventDefault();
    if (event.repeat) return;  // a key that was down before, such as during a stop, moves nothing
    held.add(event.code);
    show();
  });
  window.addEventListener("keyup", (event) => { if (held.delete(event.code)) show(); });
  window.addEventListener("blur", letGo);
  document.addEventListener("visibilitychange", () => { if (document.hidden) letGo(); });

  return {
    letGo,
    axes(speed, drives) {
      const all = deflections();
      if (drives) {
        all[5] = inOne(all[5] + all[1]);
        all[1] = 0;
      }
      return all.map((value) => value * speed);
    },
  };
}
