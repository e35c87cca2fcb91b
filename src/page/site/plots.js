// Curves over the last seconds, and bars between limits.

const SECONDS = 20;
const COLOURS = ["#6cb4ee", "#f0bf5c", "#7fc98f", "#e58a8a", "#b79cf0", "#6fd3d0", "#d8d3c4"];

// toFixed without the sign of a negative zero.
export function fixed(value, digits) {
  return value.toFixed(digits).replace(/^-(0(\.0*)?)$/, "$1");
}

// Curves of `names` in `canvas`; the range includes +-`least`.
export function curves(canvas, names, least) {
  const points = [];

  function add(t, values) {
    if (points.length && t < points[points.length - 1].t) points.length = 0;
    points.push({ t, values });
    while (points.length > 2 && points[0].t < t - SECONDS) points.shift();
  }

  function draw() {
    const scale = window.devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * scale)) {
      canvas.width = Math.round(width * scale);
      canvas.height = Math.round(height * scale);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    let top = least;
    for (const point of points) for (const value of point.values) top = Math.max(top, Math.abs(value));
    const left = 34;
    const y = (value) => height / 2 - value / top * (height / 2 - 6);
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const value of [top, 0, -top]) {
      pen.strokeStyle = "#343c43";
      pen.beginPath();
      pen.moveTo(left, y(value));
      pen.lineTo(width, y(value));
      pen.stroke();
      pen.fillStyle = "#a3adb5";
      pen.fillText(Math.abs(value) < 10 ? String(+value.toFixed(1)) : value.toFixed(0), left - 4, y(value));
    }
    if (points.length > 1) {
      const end = points[points.length - 1].t;
      const x = (t) => width - (end - t) / SECONDS * (width - left);
      names.forEach((_, i) => {
        pen.strokeStyle = COLOURS[i];
        pen.lineWidth = 1.4;
        pen.beginPath();
        for (const point of points) pen.lineTo(x(point.t), y(point.values[i]));
        pen.stroke();
      });
    }
    pen.textAlign = "left";
    names.forEach((name, i) => {
      pen.fillStyle = COLOURS[i];
      pen.fillText(name, left + 6 + 24 * i, 8);
    });
  }
  return { add, draw };
}

// One bar per joint, with a mark between its limits.
export function jointBars(box, limits) {
  const rows = limits.q_min.map((_, i) => {
    const row = document.createElement("div");
    row.className = "bar";
    row.innerHTML = "<span></span><div class=\"track\"><i></i></div><span></span>";
    row.firstElementChild.textContent = String(i + 1);
    box.append(row);
    return row;
  });
  return (q) => rows.forEach((row, i) => {
    const share = (q[i] - limits.q_min[i]) / (limits.q_max[i] - limits.q_min[i]);
    const track = row.children[1];
    track.firstElementChild.style.left = `${Math.max(0, Math.min(1, share)) * 100}%`;
    track.classList.toggle("near", share < 0.08 || share > 0.92);
    row.lastElementChild.textContent = `${fixed(q[i] * 180 / Math.PI, 1)}\u00b0`;
  });
}
