// Copyright 2026 The ros_rops authors
// SPDX-License-Identifier: Apache-2.0
'use strict';
/* What the page does: the 3D view's controls, views picked out everywhere, tables that sort. */

const $ = (selector) => document.querySelector(selector);
const $$ = (selector) => [...document.querySelectorAll(selector)];
const page = JSON.parse($('#page-data').textContent);
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const bytesOf = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16));
const shares = (hex) => bytesOf(hex).map((v) => v / 255);
const rounded = (v) => (v === 0 ? '0' : String(Number(v.toPrecision(3)))).replace('-', '−');
const length = (v) => `${rounded(v * page.factor)} ${page.unit}`;

function nice(value) {  // the next of 1, 2, 3, 5, 10, ...
  const base = 10 ** Math.floor(Math.log10(value || 1));
  return base * [1, 2, 3, 5, 10].find((step) => step * base >= value * 0.999);
}

const now = {object: null, scene: null, layer: '', colour: '', hidden: new Set(), picked: null};
let viewer = null;

// ---------------------------------------------------------------- the 3D view

function start() {
  const canvas = $('#canvas');
  if (!canvas) return;
  try {
    viewer = new Viewer(canvas, overlays);
  } catch (error) {
    noThreeD(error.message);
    return;
  }
  $('#fallback').hidden = true;
  scheme();
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', scheme);
  mouseAndTouch(canvas);
  keys(canvas);
  $$('[data-layer]').forEach((b) => b.addEventListener('click', () => setLayer(b.dataset.layer)));
  $$('[data-colour]').forEach((b) => b.addEventListener('click', () => {
    setColour(b.dataset.colour);
  }));
  $('#reset').addEventListener('click', () => viewer.reset());
  $('#nearer').addEventListener('click', () => viewer.zoom(0.8));
  $('#farther').addEventListener('click', () => viewer.zoom(1.25));
  $('#save').addEventListener('click', save);
  $('#arrow').addEventListener('change', (e) => viewer.set({arrow: e.target.checked}));
  $('#all').addEventListener('click', () => hideAll(false));
  $('#none').addEventListener('click', () => hideAll(true));
  addEventListener('beforeprint', () => {
    if (!now.scene) return;
    viewer.colours.background = [1, 1, 1];
    $('#printed').src = picture().toDataURL();
    scheme();
  });
}

function noThreeD(why) {
  $('#fallback').textContent = `No 3D view: this browser has no WebGL2 (${why}).`;
  const picture = $('#picture');
  if (picture) {
    const copy = picture.cloneNode();
    copy.removeAttribute('id');
    $('.view3d').append(copy);
  }
  $('.stage').classList.add('flat');
}

function scheme() {
  viewer.colours = {background: shares(css('--stage')), plain: shares(css('--clay')),
                    back: shares(css('--back')), arrow: shares(css('--arrow'))};
  viewer.redraw();
}

function showObject(id) {
  now.object = page.objects.find((one) => one.id === id);
  $$('.tabs button').forEach((b) => {
    b.setAttribute('aria-selected', String(Number(b.dataset.object) === id));
  });
  $$('article.object').forEach((a) => {
    a.classList.toggle('away', Number(a.dataset.object) !== id);
  });
  if (!viewer) return;
  now.scene = JSON.parse($(`#geometry-${id}`).textContent);
  now.hidden = new Set();
  $('#readout').textContent = '';
  const layers = Object.keys(now.scene.layers);
  if (!layers.length) {
    $('#fallback').textContent =
      `Nothing to show: ${Object.values(now.scene.missing).join('; ')}.`;
    $('#fallback').hidden = false;
    $('.stage').classList.add('flat');
    return;
  }
  $('#fallback').hidden = true;
  $('.stage').classList.remove('flat');
  viewer.load(now.scene);
  $('#arrow-box').hidden = !now.scene.arrow;
  $('#turn').textContent = now.scene.turn && `Turntable: ${now.scene.turn}.`;
  $('#turn').hidden = !now.scene.turn;
  listViews();
  setLayer(layers.includes('surface') ? 'surface' : layers[0]);
}

function setLayer(name) {
  now.layer = name;
  const layer = now.scene.layers[name];
  $$('[data-layer]').forEach((b) => {
    b.setAttribute('aria-pressed', String(b.dataset.layer === name));
    b.disabled = !now.scene.layers[b.dataset.layer];
    b.title = now.scene.missing[b.dataset.layer] || '';
  });
  const can = {plain: true, view: layer.view, residual: layer.residual, rgb: layer.rgb,
               state: layer.state};
  $$('[data-colour]').forEach((b) => {
    b.disabled = !can[b.dataset.colour];
    b.title = b.disabled ? 'not known of what is shown' : '';
  });
  $('#list-note').textContent = layer.faces ? 'a surface has no views to hide' : '';
  const usual = {surface: layer.rgb ? 'rgb' : 'plain', cloud: 'view', residuals: 'residual'};
  setColour(can[usual[name]] ? usual[name] : 'plain');
}

function setColour(name) {
  now.colour = name;
  $$('[data-colour]').forEach((b) => {
    b.setAttribute('aria-pressed', String(b.dataset.colour === name));
  });
  const layer = now.scene.layers[now.layer];
  if (name === 'residual') now.range = now.scene.reach * page.factor;
  apply();
}

function apply() {
  const {layer, colour} = now, range = (now.range || 1) / page.factor;
  viewer.set({layer, colour, range});
  $('#canvas').setAttribute('aria-label', `3D view of object ${now.object.id}: `
    + `${layer}, coloured by ${colour}`);
  legend();
}

function legend() {
  const box = $('#legend'), layer = now.scene.layers[now.layer];
  box.replaceChildren();
  const say = (tag, text, kind = '') => {
    const item = document.createElement(tag);
    item.textContent = text;
    item.className = kind;
    box.append(item);
    return item;
  };
  const swatch = (colour, text) => {
    const line = say('div', text, 'swatch');
    const spot = document.createElement('i');
    spot.style.background = colour;
    line.prepend(spot);
  };
  if (now.colour === 'residual') {
    scaleLegend(say, layer);
    swatch('rgb(140,140,148)', 'no other view saw it');
    if (layer.state) swatch(STATES_TEXT[2][0], STATES_TEXT[2][1]);
  } else if (now.colour === 'state') {
    STATES_TEXT.forEach(([colour, text]) => swatch(colour, text));
  } else if (now.colour === 'view') {
    say('p', 'as in the list below');
  }
  if (layer.filled) {
    const [light, dark] = FILLED.map((c) => `rgb(${c.join(',')})`);
    swatch(`repeating-linear-gradient(-45deg, ${light} 0 3px, ${dark} 3px 6px)`,
           'filled: no view saw a surface there');
  }
}

const STATES_TEXT = [0, 1, 2].map((k) => [
  `rgb(${STATES[k].join(',')})`,
  ['alone: no other view saw it', 'confirmed by another view', 'contradicted by another view'][k],
]);

function scaleLegend(say, layer) {
  const stops = SCALE.map((c) => `rgb(${c.join(',')})`).slice(layer.signed ? 0 : 2);
  say('p', layer.signed ? `residual, ${page.unit} (in front of what the others saw: +)`
    : `size of the residuals around it, ${page.unit}`);
  const bar = say('div', '', 'scale');
  bar.style.background = `linear-gradient(90deg, ${stops.join(',')})`;
  const ticks = say('div', '', 'ticks');
  for (const t of layer.signed ? [-1, -0.5, 0, 0.5, 1] : [0, 0.25, 0.5, 0.75, 1]) {
    const tick = document.createElement('span');
    tick.textContent = (t === 1 ? '≥ ' : t === -1 ? '≤ ' : '') + rounded(t * now.range);
    ticks.append(tick);
  }
  const steps = say('div', '', 'steps');
  for (const [title, text, factor] of [['Narrower scale', 'narrower', 0.5],
                                       ['Wider scale', 'wider', 2]]) {
    const button = document.createElement('button');
    Object.assign(button, {type: 'button', textContent: text, title});
    button.addEventListener('click', () => {
      now.range = Number((now.range * factor).toPrecision(6));
      apply();
    });
    steps.append(button);
  }
}

/** Scale bar, and the label of the arrow: drawn again after each frame. */
function overlays() {
  if (!now.scene || !now.scene.edge) return;
  const unit = viewer.unit() * page.factor, size = nice(40 * unit);
  $('#bar').style.width = `${size / unit}px`;
  $('#bar span').textContent = `${rounded(size)} ${page.unit}`;
  arrowLabel();
}

/** Put the arrow's label beside it: within the picture, on nothing else that is written there. */
function arrowLabel() {
  const ends = viewer.arrowEnds(), tag = $('#tag');
  const {clientWidth: w, clientHeight: h} = viewer.canvas;
  const within = ([x, y]) => x > 0 && y > 0 && x < w && y < h;
  tag.hidden = !ends || !ends.some(within);
  if (tag.hidden) return;
  const {said} = now.scene.arrow;
  const place = ends[0][2] < -0.8 * now.scene.radius ? 'from behind' : 'from here';
  tag.textContent = `look ${place}${said ? `: shows ${said} of the unseen` : ''}`;
  const [a, b] = [tag.offsetWidth / 2, tag.offsetHeight / 2];
  const wide = 0.06 * now.scene.radius / viewer.unit() + 6;
  const [tail, tip] = ends, middle = [(tail[0] + tip[0]) / 2, (tail[1] + tip[1]) / 2];
  const beside = Math.abs(tail[0] - tip[0]) / 2 + wide + a;
  const above = Math.abs(tail[1] - tip[1]) / 2 + wide + b;
  const kept = (v, half, size) => Math.min(Math.max(v, half + 4), Math.max(size - half - 4, half));
  const boxes = [[w - 50, 0, w, 170], [0, h - 44, 150, h], [0, 0, w, 26]];
  const hits = ([x, y]) => {  // how much of the label lies on something else
    let sum = 0;
    for (const [l, t, r, d] of boxes) {
      sum += Math.max(0, Math.min(x + a, r) - Math.max(x - a, l))
        * Math.max(0, Math.min(y + b, d) - Math.max(y - b, t));
    }
    for (let k = 0; k <= 20; k++) {
      const [u, v] = [0, 1].map((j) => tail[j] + (tip[j] - tail[j]) * k / 20);
      if (Math.abs(u - x) < a + wide && Math.abs(v - y) < b + wide) sum += 1e4;
    }
    return sum - Math.hypot(x - w / 2, y - h / 2);  // rather away from the object
  };
  const places = [
    [tail[0] + beside, tail[1]], [tail[0] - beside, tail[1]], [middle[0] + beside, middle[1]],
    [middle[0] - beside, middle[1]], [tail[0], middle[1] + above], [tail[0], middle[1] - above],
  ].map(([x, y]) => [kept(x, a, w), kept(y, b, h)]);
  const [x, y] = places.reduce((best, one) => (hits(one) < hits(best) ? one : best));
  tag.style.left = `${x}px`;
  tag.style.top = `${y}px`;
}

function mouseAndTouch(canvas) {
  const down = new Map();
  let moved = 0, began = null;
  const spread = () => {
    const [a, b] = [...down.values()];
    return {x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, size: Math.hypot(a.x - b.x, a.y - b.y),
            angle: Math.atan2(b.y - a.y, b.x - a.x)};
  };
  canvas.addEventListener('pointerdown', (e) => {
    canvas.setPointerCapture(e.pointerId);
    if (!down.size) [moved, began] = [0, viewer.turn];
    down.set(e.pointerId, {x: e.clientX, y: e.clientY, pan: e.button !== 0 || e.shiftKey});
  });
  canvas.addEventListener('pointermove', (e) => {
    const was = down.get(e.pointerId);
    if (!was || !now.scene) return;
    const before = down.size === 2 ? spread() : null;
    const [dx, dy] = [e.clientX - was.x, e.clientY - was.y];
    Object.assign(was, {x: e.clientX, y: e.clientY});
    moved += Math.abs(dx) + Math.abs(dy);
    if (before) {
      const after = spread(), rect = canvas.getBoundingClientRect();
      viewer.pan(after.x - before.x, after.y - before.y);
      viewer.zoom(before.size / Math.max(after.size, 1),
                  after.x - rect.left - rect.width / 2, after.y - rect.top - rect.height / 2);
      viewer.rotate(0, 0, after.angle - before.angle);
    } else if (down.size === 1) {
      if (was.pan) viewer.pan(dx, dy);
      else viewer.rotate(dx * 0.008, dy * 0.008);
    }
  });
  const up = (e) => {
    const known = down.delete(e.pointerId);
    if (known && e.type === 'pointerup' && moved < 5 && !down.size) read(e);
    if (known && e.type === 'pointercancel') {  // the page scrolls: the finger meant that
      viewer.turn = began;
      viewer.redraw();
    }
  };
  canvas.addEventListener('pointerup', up);
  canvas.addEventListener('pointercancel', up);
  canvas.addEventListener('contextmenu', (e) => e.preventDefault());
  // Who scrolls the page and comes over the picture goes on scrolling.
  let scrolled = -Infinity;
  addEventListener('wheel', (e) => {
    if (e.target !== canvas) scrolled = e.timeStamp;
  }, {passive: true});
  canvas.addEventListener('wheel', (e) => {
    if (e.timeStamp - scrolled < 300 && !e.ctrlKey) {
      scrolled = e.timeStamp;
      return;
    }
    e.preventDefault();
    const rect = canvas.getBoundingClientRect(), lines = e.deltaMode === 1 ? 16 : 1;
    viewer.zoom(Math.exp(Math.max(-0.5, Math.min(0.5, e.deltaY * lines * 0.0015))),
                e.clientX - rect.left - rect.width / 2, e.clientY - rect.top - rect.height / 2);
  }, {passive: false});
}

/** Tell what is known of the point under the pointer. */
function read(event) {
  const rect = viewer.canvas.getBoundingClientRect();
  const {index, filled} = viewer.pick(event.clientX - rect.left, event.clientY - rect.top);
  viewer.redraw();
  if (index < 0) {
    $('#readout').textContent = '';
    return;
  }
  const layer = now.scene.layers[now.layer];
  const known = viewer.facts(index);
  const words = filled ? ['filled: no view saw a surface here'] : [];
  if (known.view !== null && !filled) words.push(now.object.views[known.view].short);
  if (known.residual !== null && !filled) words.push(`residual ${length(known.residual)}`);
  if (known.state !== null) words.push(STATES_TEXT[known.state][1]);
  words.push(`at ${known.position.map((v) => rounded(v * page.factor)).join(', ')} ${page.unit}`);
  $('#readout').textContent = words.join(' · ');
}

function keys(canvas) {
  canvas.addEventListener('keydown', (e) => {
    const step = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[e.key];
    if (!now.scene || e.ctrlKey || e.altKey || e.metaKey) return;
    if (step && e.shiftKey) viewer.pan(20 * step[0], 20 * step[1]);
    else if (step) viewer.rotate(0.1 * step[0], 0.1 * step[1]);
    else if (e.key === '+' || e.key === '=') viewer.zoom(0.85);
    else if (e.key === '-' || e.key === '_') viewer.zoom(1 / 0.85);
    else if (e.key === '0' || e.key === 'Home') viewer.reset();
    else return;
    e.preventDefault();
  });
}

/** The 3D view as it stands, with its scale bar in it: what is printed or saved gets resized. */
function picture() {
  viewer.draw();
  const {canvas} = viewer, copy = document.createElement('canvas');
  [copy.width, copy.height] = [canvas.width, canvas.height];
  const pen = copy.getContext('2d'), sharp = sharpness();
  pen.drawImage(canvas, 0, 0);
  pen.scale(sharp, sharp);
  const wide = parseFloat($('#bar').style.width) || 0, high = canvas.clientHeight;
  const dark = viewer.colours.background.every((v) => v < 0.5);
  pen.strokeStyle = pen.fillStyle = dark ? '#ffffff' : '#000000';
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(12, high - 18);
  pen.lineTo(12, high - 11);
  pen.lineTo(12 + wide, high - 11);
  pen.lineTo(12 + wide, high - 18);
  pen.stroke();
  pen.font = '12px sans-serif';
  pen.fillText($('#bar span').textContent, 14, high - 22);
  return copy;
}

function save() {
  picture().toBlob((blob) => {
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = `object_${now.object.id}_${now.layer}_${now.colour}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
}

// ---------------------------------------------------------------- views

function listViews() {
  $('#list').replaceChildren(...now.object.views.map((view, k) => {
    const label = document.createElement('label'), box = document.createElement('input');
    const spot = document.createElement('i'), name = document.createElement('span');
    box.type = 'checkbox';
    box.checked = true;
    box.addEventListener('change', () => {
      if (box.checked) now.hidden.delete(k); else now.hidden.add(k);
      tint();
    });
    spot.style.background = view.colour;
    name.textContent = `${view.number} ${view.short}`;
    label.title = view.left ? `${view.name}: left out of the model` : view.name;
    label.classList.toggle('left', view.left);
    label.dataset.row = view.number;
    label.append(box, spot, name);
    return label;
  }));
  tint();
  mark();
}

function hideAll(hide) {
  now.hidden = new Set(hide ? now.object.views.keys() : []);
  $$('#list input').forEach((box) => { box.checked = !hide; });
  tint();
}

function tint() {
  if (!viewer || !now.scene) return;
  const bytes = new Uint8Array(4 * Math.max(now.object.views.length, 1));
  now.object.views.forEach((view, k) => {
    const alpha = now.hidden.has(k) ? 0
      : now.picked === null || now.picked === view.number ? 255 : 128;
    bytes.set([...bytesOf(view.colour), alpha], 4 * k);
  });
  viewer.retint(bytes);
}

/** Pick a view out, in the 3D view, in the tables and in the graph; the same again lets it go. */
function pick(number) {
  now.picked = now.picked === number ? null : number;
  const home = page.objects.find((one) => one.views.some((view) => view.number === number));
  if (home && now.picked !== null && home !== now.object) showObject(home.id);
  mark();
  tint();
}

function mark() {
  $$('[data-row], .node').forEach((item) => {
    const number = Number(item.dataset.row ?? item.dataset.view);
    item.classList.toggle('picked', number === now.picked);
  });
  $$('.graph').forEach((figure) => {
    const node = figure.querySelector('.node.picked');
    figure.classList.toggle('some', Boolean(node));
    figure.querySelectorAll('.edge').forEach((edge) => {
      const {a, b} = edge.dataset;
      edge.classList.toggle('picked', Boolean(node) && [a, b].includes(node.dataset.place));
    });
  });
}

function openStory() {
  const target = location.hash.startsWith('#view-') && document.getElementById(
    location.hash.slice(1));
  if (target) target.open = true;
}

// ---------------------------------------------------------------- tables

function sortBy(table, column, button) {
  const body = table.tBodies[0], heads = [...table.tHead.rows[0].cells];
  const down = heads[column].getAttribute('aria-sort') === 'ascending';
  heads.forEach((head) => head.removeAttribute('aria-sort'));
  heads[column].setAttribute('aria-sort', down ? 'descending' : 'ascending');
  const key = (row) => row.cells[column].dataset.key ?? row.cells[column].textContent.trim();
  const rows = [...body.rows].map((row) => ({row, key: key(row)}));
  const numbers = rows.every((one) => one.key === '' || !Number.isNaN(Number(one.key)));
  rows.sort((a, b) => {
    if (a.key === '' || b.key === '') return (a.key === '') - (b.key === '');  // unknown: last
    const order = numbers ? a.key - b.key : a.key.localeCompare(b.key, undefined, {numeric: true});
    return down ? -order : order;
  });
  body.append(...rows.map((one) => one.row));
}

$$('table.sortable').forEach((table) => {
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    const button = head.querySelector('button');
    if (button) button.addEventListener('click', () => sortBy(table, column, button));
  });
});
$$('.tabs button').forEach((b, k, all) => {
  b.addEventListener('click', () => showObject(Number(b.dataset.object)));
  b.addEventListener('keydown', (e) => {
    const step = {ArrowLeft: -1, ArrowRight: 1}[e.key];
    if (!step) return;
    const other = all[(k + step + all.length) % all.length];
    other.focus();
    other.click();
    e.preventDefault();
  });
});
$$('.node').forEach((node) => {
  const act = () => pick(Number(node.dataset.view));
  node.addEventListener('click', act);
  node.addEventListener('keydown', (e) => {
    if (e.key === 'Enter' || e.key === ' ') { e.preventDefault(); act(); }
  });
});
$$('tr[data-row]').forEach((row) => row.addEventListener('click', (e) => {
  if (!e.target.closest('a')) pick(Number(row.dataset.row));
}));
$$('[data-look]').forEach((b) => b.addEventListener('click', () => {
  const from = now.object.directions[Number(b.dataset.look)];
  if (viewer && from) {
    viewer.lookFrom(from);
    $('.stage').scrollIntoView({block: 'nearest'});
  }
}));
addEventListener('hashchange', openStory);
start();
openStory();
if (page.objects.length) showObject(page.objects[0].id);
document.documentElement.dataset.ready = 'yes';
