// The last seconds again, from the states and pictures that this page received: no request to the robot.

const SECONDS = 30;
const STEP_MS = 40;

// Without the entries older than SECONDS before `end`, ms.
function recent(entries, end) {
  const first = entries.findIndex(({ at }) => at >= end - 1000 * SECONDS);
  return first <= 0 ? entries : entries.slice(first);
}

// The newest entry not after `at`, or the first.
function entryAt(entries, at) {
  let [low, high] = [0, entries.length];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (entries[middle].at <= at) low = middle;
    else high = middle;
  }
  return entries[low];
}

// parts: elements replay, play, moment (a range) and ago. show({ state, picture, poses }): displays what has changed, null else. changed(on): live or not.
export function replays(parts, { show, changed }) {
  const kept = { state: [], picture: [], poses: [] };
  let film = null;  // what is replayed; null: live
  let position = 0;  // ms
  let shown = {};
  let isPlaying = false;
  let before = 0;

  // The slider's value is rounded, so it may end a moment before the film.
  function isOver() {
    return film.end - position < 1;
  }
  function tell() {
    parts.replay.textContent = film ? "Live" : `Replay ${SECONDS} s`;
    parts.replay.classList.toggle("main", Boolean(film));
    for (const name of ["play", "moment", "ago"]) parts[name].hidden = !film;
    parts.play.textContent = isPlaying ? "Hold" : "Play";
    if (!film) return;
    parts.moment.value = String(position - film.begin);
    parts.ago.textContent = `\u2212${((film.end - position) / 1000).toFixed(1)} s`;
  }
  function go(to) {
    position = Math.max(film.begin, Math.min(film.end, to));
    if (isOver()) isPlaying = false;
    tell();
    const before = shown;
    shown = {};
    const changes = {};
    for (const [kind, entries] of Object.entries(film.entries)) {
      shown[kind] = entries.length ? entryAt(entries, position).what : null;
      changes[kind] = shown[kind] === before[kind] ? null : shown[kind];
    }
    if (Object.values(changes).some((what) => what !== null)) show(changes);
  }
  function begin() {
    if (kept.state.length < 2) return;
    const end = kept.state[kept.state.length - 1].at;
    const entries = Object.fromEntries(Object.entries(kept).map(([kind, all]) => [kind, recent(all, end)]));
    film = { entries, begin: entries.state[0].at, end };
    parts.moment.max = String(film.end - film.begin);
    shown = {};
    changed(true);
    play(true);
    go(film.begin);
  }
  function live() {
    if (!film) return;
    film = null;
    isPlaying = false;
    tell();
    changed(false);
  }
  function play(on) {
    if (on && isOver()) position = film.begin;
    isPlaying = on;
    before = performance.now();
    tell();
  }

  parts.replay.onclick = () => (film ? live() : begin());
  parts.play.onclick = () => play(!isPlaying);
  parts.moment.oninput = () => {
    isPlaying = false;
    go(film.begin + Number(parts.moment.value));
  };
  setInterval(() => {
    if (!isPlaying) return;
    const now = performance.now();
    go(position + now - before);
    before = now;
  }, STEP_MS);
  tell();

  return {
    live,
    isOn: () => film !== null,
    // The robot's time that is shown, s; null: live.
    time: () => (film && shown.state ? shown.state.t : null),
    toggle: () => parts.replay.click(),
    // kind: state, picture or poses, as a message or a blob.
    keep(kind, what) {
      const now = performance.now();
      kept[kind].push({ at: now, what });
      kept[kind] = recent(kept[kind], now);
    },
  };
}
