// Curves over the last seconds, bars between limits, and the axes of the end effector.

import { fixed } from "./facts.js";
import { explain } from "./tips.js";

const SECONDS = 20;
const COLOURS = ["#6cb4ee", "#f0bf5c", "#7fc98f", "#f09a9a", "#c3abf5", "#6fd3d0", "#d8d3c4"];
const GAP_S = 0.5;  // between two points that no line joins
const NEAR_deg = 10;
const MARK = "#f0bf5c";
const LINE = "#4a555e";
const DIM = "#b3bcc3";
const LEGEND = 13;  // px above the curves
const FONT = "11px system-ui, sans-serif";

// The canvas's pen, in CSS pixels and cleared, with its size; null while it is not displayed.
function penOf(canvas) {
  const scale = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width) return null;
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  pen.font = FONT;
  return { pen, width, height };
}

// The range of the axis: [0, top] for a plot with `upTo`, where higher values are drawn at the top; else symmetric, at least +-`least`.
function rangeOf(points, { least, upTo }) {
  if (upTo) return [0, upTo];
  let top = least;
  for (const point of points) for (const value of point.values) top = Math.max(top, Math.abs(value));
  return [-top, top];
}

// A plot in `box`: title, unit, names of the curves, what it means, least or upTo (rangeOf), now(values): the number beside the title.
export function curves(box, options) {
  const heading = document.createElement("h2");
  const unit = document.createElement("span");
  const value = document.createElement("output");
  const canvas = document.createElement("canvas");
  unit.className = "dim";
  unit.textContent = options.unit;
  heading.append(`${options.title} `, unit, value);
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${options.title} in the last ${SECONDS} seconds`);
  explain(heading, options.tip);
  box.append(heading, canvas);
  const points = [];

  // values: null when there are none at this time.
  function add(t, values) {
    if (points.length && t < points[points.length - 1].t) points.length = 0;
    if (values) points.push({ t, values });
    while (points.length && points[0].t < t - SECONDS) points.shift();
    const text = values ? options.now(values) : options.none;
    if (value.textContent !== text) value.textContent = text;
  }

  function grid(pen, width, y, range) {
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const at of [range[1], (range[0] + range[1]) / 2, range[0]]) {
      pen.strokeStyle = LINE;
      pen.beginPath();
      pen.moveTo(34, y(at));
      pen.lineTo(width, y(at));
      pen.stroke();
      pen.fillStyle = DIM;
      pen.fillText(fixed(at, Math.abs(at) < 10 && at % 1 !== 0 ? 1 : 0), 30, y(at));
    }
  }

  // mark: a time that is marked, s; null: none.
  function draw(mark = null) {
    const drawn = penOf(canvas);
    if (!drawn) return;
    const { pen, width, height } = drawn;
    const range = rangeOf(points, options);
    const top = LEGEND + 7;
    const y = (at) => top + (range[1] - Math.min(at, range[1])) / (range[1] - range[0]) * (height - top - 7);
    grid(pen, width, y, range);
    if (points.length > 1) {
      const end = points[points.length - 1].t;
      const x = (t) => width - (end - t) / SECONDS * (width - 34);
      options.names.forEach((_, i) => {
        pen.strokeStyle = COLOURS[i];
        pen.lineWidth = 1.5;
        pen.beginPath();
        points.forEach(({ t, values }, k) => {
          const isGap = k > 0 && t - points[k - 1].t > GAP_S;
          pen[isGap ? "moveTo" : "lineTo"](x(t), y(values[i]));
        });
        pen.stroke();
      });
      if (mark !== null && mark > end - SECONDS) {
        pen.strokeStyle = MARK;
        pen.lineWidth = 2;
        pen.beginPath();
        pen.moveTo(x(mark), 0);
        pen.lineTo(x(mark), height);
        pen.stroke();
      }
    }
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    options.names.forEach((name, i) => {
      pen.fillStyle = COLOURS[i];
      pen.fillText(name, 40 + 16 * i, LEGEND / 2);
    });
  }
  return { add, draw };
}

const degrees = (angle) => angle * 180 / Math.PI;

// Distances to the nearer limits, in degrees.
export function roomOf(q, limits) {
  return q.map((angle, i) => degrees(Math.min(angle - limits.q_min[i], limits.q_max[i] - angle)));
}

// One bar per joint, with a mark between its limits.
export function jointBars(box, limits) {
  const rows = limits.q_min.map((_, i) => {
    const row = document.createElement("div");
    row.className = "bar";
    row.innerHTML = "<span></span><div class=\"track\"><i></i></div><span></span><span></span>";
    row.firstElementChild.textContent = String(i + 1);
    row.firstElementChild.style.color = COLOURS[i];
    const [least, most] = [limits.q_min[i], limits.q_max[i]].map((limit) => `${fixed(degrees(limit), 1)}\u00b0`);
    explain(row, `Joint ${i + 1}: its angle, between ${least} and ${most}, and the distance to the nearer of the two; amber below ${NEAR_deg}\u00b0.`);
    box.append(row);
    return row;
  });
  return (q) => roomOf(q, limits).forEach((room, i) => {
    const share = (q[i] - limits.q_min[i]) / (limits.q_max[i] - limits.q_min[i]);
    const [, track, angle, left] = rows[i].children;
    track.firstElementChild.style.left = `${Math.max(0, Math.min(1, share)) * 100}%`;
    rows[i].classList.toggle("near", room < NEAR_deg);
    angle.textContent = `${fixed(degrees(q[i]), 1)}\u00b0`;
    left.textContent = `${fixed(room, 0)}\u00b0`;
  });
}

// Where a point [x, y, z] of the base is drawn, in lengths of an axis: seen from ahead, left and above.
function project([x, y, z]) {
  const [azimuth, elevation] = [0.6, 0.45];
  const right = y * Math.cos(azimuth) - x * Math.sin(azimuth);
  const near = x * Math.cos(azimuth) + y * Math.sin(azimuth);
  return [right, near * Math.sin(elevation) - z * Math.cos(elevation)];
}

function arrow({ pen, width, height }, axis, colour, thickness, name) {
  const size = 0.38 * Math.min(width, height);
  const [x, y] = project(axis);
  const end = [width / 2 + x * size, height / 2 + y * size];
  pen.strokeStyle = colour;
  pen.fillStyle = colour;
  pen.lineWidth = thickness;
  pen.beginPath();
  pen.moveTo(width / 2, height / 2);
  pen.lineTo(...end);
  pen.stroke();
  if (!name) return;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillText(name, end[0] + 9 * Math.sign(x), end[1] + (y < 0 ? -7 : 8));
}

// The axes of O_T_EE (column-major) in those of the base.
export function triad(canvas, T) {
  const drawn = penOf(canvas);
  if (!drawn) return;
  const colours = [COLOURS[3], COLOURS[2], COLOURS[0]];
  for (let i = 0; i < 3; ++i) arrow(drawn, [0, 1, 2].map((k) => (k === i ? 1 : 0)), colours[i], 1, "");
  for (let i = 0; i < 3; ++i) arrow(drawn, T.slice(4 * i, 4 * i + 3), colours[i], 4, "xyz"[i]);
}
