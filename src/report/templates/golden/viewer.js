'use strict';
// Exchanges expected and actual pictures of a section under the mouse, and shows their difference.
//
// The section's data: {views: [{name, width, height, expected, actual, same}], small: [columns, width, height], interval, span,
// first, firstView}; expected and actual: {frames, strip, keys: {frame: address}}. `same` lists the key pictures that actual shares
// with expected; a strip that they share is null in actual.
function load(address) {
  return new Promise((done, failed) => {
    const image = new Image();
    image.onload = () => done(image);
    image.onerror = () => failed(new Error('a picture of the page is damaged'));
    image.src = address;
  });
}

async function loadSide(side) {
  const loaded = {frames: side.frames, strip: side.strip && await load(side.strip), keys: {}};
  for (const frame in side.keys) loaded.keys[frame] = await load(side.keys[frame]);
  return loaded;
}

class Viewer {
  constructor(section) {
    this.section = section;
    this.data = JSON.parse(section.querySelector('script').textContent);
    this.canvases = [...section.querySelectorAll('canvas')];
    this.captions = [...section.querySelectorAll('.panels figcaption')];
    this.slider = section.querySelector('input');
    this.swapped = false;
    this.view = this.data.firstView;
  }

  async start() {
    this.sides = [];
    for (const view of this.data.views) {
      const expected = await loadSide(view.expected);
      const actual = await loadSide(view.actual);
      actual.strip = actual.strip || expected.strip;
      for (const frame of view.same) actual.keys[frame] = expected.keys[frame];
      this.sides.push([expected, actual]);
    }
    this.slider.max = Math.max(...this.sides[0].map(side => side.frames)) - 1;
    this.slider.value = this.data.first;
    this.slider.addEventListener('input', () => this.draw());
    this.section.querySelectorAll('button.view').forEach((button, i) =>
      button.addEventListener('click', () => { this.view = i; this.draw(); }));
    for (const [name, step] of [['previous', -1], ['next', 1]]) {
      this.section.querySelector('button.' + name).addEventListener('click', () => this.toKey(step));
    }
    for (const canvas of this.canvases.slice(0, 2)) {
      canvas.addEventListener('mouseenter', () => { this.swapped = true; this.draw(); });
      canvas.addEventListener('mouseleave', () => { this.swapped = false; this.draw(); });
    }
    this.makeMark();
    this.draw();
  }

  get frame() { return Number(this.slider.value); }

  toKey(step) {
    const keys = Object.keys(this.sides[this.view][0].keys).map(Number);
    const ahead = keys.filter(key => step * (key - this.frame) > 0);
    if (ahead.length === 0) return;
    this.slider.value = step > 0 ? Math.min(...ahead) : Math.max(...ahead);
    this.draw();
  }

  // The frame whole where it is a key picture, else out of the strip of small ones.
  paint(canvas, side) {
    const context = canvas.getContext('2d', {willReadFrequently: true});
    const {width, height} = this.data.views[this.view];
    canvas.width = width;
    canvas.height = height;
    context.imageSmoothingEnabled = false;
    if (this.frame >= side.frames) return;
    const whole = side.keys[this.frame];
    if (whole) {
      context.drawImage(whole, 0, 0);
      return;
    }
    const [columns, w, h] = this.data.small;
    context.drawImage(side.strip, this.frame % columns * w, Math.floor(this.frame / columns) * h, w, h,
                      0, 0, width, height);
  }

  paintDifference() {
    const [a, b, out] = this.canvases.map(canvas => canvas.getContext('2d'));
    const {width, height} = this.data.views[this.view];
    this.canvases[2].width = width;
    this.canvases[2].height = height;
    const difference = a.getImageData(0, 0, width, height);
    const other = b.getImageData(0, 0, width, height);
    for (let i = 0; i < difference.data.length; ++i) {
      difference.data[i] = i % 4 === 3 ? 255 : Math.min(255, 16 * Math.abs(difference.data[i] - other.data[i]));
    }
    out.putImageData(difference, 0, 0);
  }

  // A line across the plot, and where its axis begins and ends: gnuplot's grid tells.
  makeMark() {
    const svg = this.section.querySelector('.joints svg');
    const lines = [...svg.querySelectorAll('path.gridline')].map(
      path => path.getAttribute('d').match(/-?[\d.]+/g).map(Number));
    const level = lines.find(([, y1, , y2]) => y1 === y2);
    const upright = lines.find(([x1, , x2]) => x1 === x2);
    this.range = [level[0], level[2]];
    this.mark = document.createElementNS('http://www.w3.org/2000/svg', 'line');
    this.mark.setAttribute('class', 'mark');
    this.mark.setAttribute('y1', upright[1]);
    this.mark.setAttribute('y2', upright[3]);
    svg.appendChild(this.mark);
    svg.addEventListener('click', event => {
      const box = svg.getBoundingClientRect();
      const x = (event.clientX - box.left) / box.width * svg.viewBox.baseVal.width;
      const t = (x - this.range[0]) / (this.range[1] - this.range[0]) * this.data.span;
      this.slider.value = Math.round(t / this.data.interval);
      this.draw();
    });
  }

  draw() {
    const [expected, actual] = this.sides[this.view];
    const shown = this.swapped ? [actual, expected] : [expected, actual];
    shown.forEach((side, i) => this.paint(this.canvases[i], side));
    this.paintDifference();
    const names = this.swapped ? ['actual', 'expected'] : ['expected', 'actual'];
    names.forEach((name, i) => { this.captions[i].textContent = name; });
    const seconds = this.frame * this.data.interval;
    const x = this.range[0] + seconds / this.data.span * (this.range[1] - this.range[0]);
    this.mark.setAttribute('x1', x);
    this.mark.setAttribute('x2', x);
    const kind = expected.keys[this.frame] && actual.keys[this.frame] ? 'key picture' : 'small picture';
    const missing = [expected, actual].some(side => this.frame >= side.frames) ? ', not in both films' : '';
    this.section.querySelector('.where').textContent =
      `frame ${this.frame} of ${Number(this.slider.max) + 1}, ${seconds.toFixed(2)} s, ${kind}${missing}`;
    this.section.querySelectorAll('button.view').forEach((button, i) =>
      button.classList.toggle('chosen', i === this.view));
    this.section.dataset.ready = 'yes';
  }
}

for (const section of document.querySelectorAll('section.case')) new Viewer(section).start();
